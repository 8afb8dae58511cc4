/** Serves the built page, and the test pages, for the browser tests. */

import { createServer, preview } from "vite";
import type {} from "vitest";
import type { TestProject } from "vitest/node";

declare module "vitest" {
  interface ProvidedContext {
    /** The page from a server that sends the headers for threads. */
    isolatedUrl: string;
    /** The page from a server that does not, as most static hosts. */
    plainUrl: string;
    /** The sources, for pages of the tests themselves. */
    sourceUrl: string;
  }
}

export default async function serve(project: TestProject): Promise<() => Promise<void>> {
  const isolated = await preview({ preview: { port: 0, host: "127.0.0.1" } });
  const plain = await preview({
    configFile: false,
    preview: { port: 0, host: "127.0.0.1" },
  });
  const source = await createServer({ server: { port: 0, host: "127.0.0.1", hmr: false } });
  await source.listen();
  project.provide("isolatedUrl", isolated.resolvedUrls!.local[0]);
  project.provide("plainUrl", plain.resolvedUrls!.local[0]);
  project.provide("sourceUrl", source.resolvedUrls!.local[0]);
  return async () => {
    await Promise.all([isolated.close(), plain.close(), source.close()]);
  };
}
