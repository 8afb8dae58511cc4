/** A visit to the page in a real browser, which notes all that must not happen. */

import { chromium, type Browser, type BrowserContext, type Page } from "playwright-core";

import type { Prediction } from "footprints-edge";

import { fixturePath } from "../../../runtime/js/tests/fixtures";

/** No calls home of the browser's own: they would look like requests of the page. */
const FLAGS = [
  "--no-sandbox",
  "--disable-gpu",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
];

/** Multiplies every time limit, for machines that are busy with other things. */
export const PATIENCE = Number(process.env.PATIENCE ?? 1);

export interface VisitOptions {
  width?: number;
  height?: number;
  touch?: boolean;
  /** A film for the camera; without one there is no camera. */
  film?: string;
  allowCamera?: boolean;
  flags?: string[];
}

export class Visit {
  /** What the page complained about; tests expect it to stay empty. */
  readonly errors: string[] = [];
  /** Addresses that the page, its workers or its service worker asked for. */
  readonly requests: string[] = [];

  private constructor(
    private readonly browser: Browser,
    readonly context: BrowserContext,
    readonly page: Page,
  ) {}

  /** Opens an empty page, ready to go somewhere. */
  static async begin(options: VisitOptions = {}): Promise<Visit> {
    const film = options.film && [
      "--use-fake-device-for-media-stream",
      `--use-file-for-fake-video-capture=${fixturePath(options.film)}`,
    ];
    const browser = await chromium.launch({
      executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
      args: [...FLAGS, ...(film || []), ...(options.flags ?? [])],
    });
    const context = await browser.newContext({
      viewport: { width: options.width ?? 1280, height: options.height ?? 800 },
      hasTouch: options.touch ?? false,
      permissions: options.allowCamera === false ? [] : ["camera"],
    });
    const page = await context.newPage();
    const visit = new Visit(browser, context, page);
    context.on("request", (request) => visit.requests.push(request.url()));
    page.on("pageerror", (error) => visit.errors.push(String(error)));
    page.on("console", (message) => {
      if (message.type() === "error") visit.errors.push(message.text());
    });
    await page.addInitScript(() => {
      const results: unknown[] = [];
      document.addEventListener("footprints-result", (event) => {
        results.push((event as CustomEvent).detail);
      });
      Object.assign(globalThis, { results });
    });
    return visit;
  }

  async end(): Promise<void> {
    await this.browser.close();
  }

  /** Waits until the page has shown so many results since it was loaded. */
  async resultCount(atLeast: number, timeoutS = 30): Promise<void> {
    await this.page.waitForFunction(
      (count) => (globalThis as unknown as { results: unknown[] }).results.length >= count,
      atLeast,
      { timeout: 1000 * timeoutS * PATIENCE },
    );
  }

  /** How many results the page has shown since it was loaded. */
  async results(): Promise<number> {
    return this.page.evaluate(() => (globalThis as unknown as { results: unknown[] }).results.length);
  }

  /** The maps of the last result: float32 [4, height, width], as in the fixtures. */
  async maps(): Promise<{ shape: number[]; data: Float32Array }> {
    const { shape, url } = await this.page.evaluate(async () => {
      const results = (globalThis as unknown as { results: { prediction: Prediction }[] }).results;
      const { prediction } = results.at(-1)!;
      const channels = [
        prediction.visibleGroundProbability,
        prediction.groundProbability,
        prediction.visibleDepthM,
        prediction.unmaskedGroundDepthM,
      ];
      const reader = new FileReader();
      reader.readAsDataURL(new Blob(channels as BlobPart[]));
      await new Promise((resolve) => (reader.onload = resolve));
      return { shape: [4, prediction.mapSize.height, prediction.mapSize.width], url: reader.result as string };
    });
    const bytes = Buffer.from(url.slice(url.indexOf(",") + 1), "base64");
    return { shape, data: new Float32Array(Uint8Array.from(bytes).buffer) };
  }

  async text(selector: string): Promise<string> {
    return (await this.page.textContent(selector)) ?? "";
  }

  /** Waits until an element says something that matches. */
  async says(selector: string, words: RegExp): Promise<string> {
    await this.page.waitForFunction(
      ([where, source]) => new RegExp(source).test(document.querySelector(where)!.textContent!),
      [selector, words.source] as const,
      { timeout: 20_000 * PATIENCE },
    );
    return this.text(selector);
  }
}
