/** The page's end of the line to the worker that looks at pictures. */

import { Prediction, type GroundPath } from "footprints-edge";

import type { Analysis, Asked, Engine, NoPath, Point, Replied, Reply, Request, Task } from "../messages";

type Kind = Reply["kind"];
type ReplyOf<K extends Kind> = Extract<Reply, { kind: K }>;

/** A worker with a loaded model. */
export class Analyst {
  /** Held by the worker as long as it lives: nothing else tells that one has ended for want of memory. */
  private readonly lock = `analyst ${Math.random()}`;
  private readonly worker = new Worker(new URL("../workers/analyst.ts", import.meta.url), {
    type: "module",
    name: this.lock,
  });
  private readonly waiting = new Map<number, (reply: Reply) => void>();
  private asked = 0;
  threads: number | null = null;
  /** Whether the worker is gone. */
  ended = false;

  private constructor(readonly engine: Engine) {
    this.worker.onmessage = ({ data: { id, reply } }: MessageEvent<Replied>) => {
      this.waiting.get(id)?.(reply);
      this.waiting.delete(id);
    };
    this.worker.onerror = ({ message }) => {
      this.fail(message || "the worker did not start");
    };
  }

  private fail(message: string): void {
    for (const answer of this.waiting.values()) answer({ kind: "failed", message });
    this.waiting.clear();
  }

  /**
   * Starts a worker, which fetches and loads the model.
   *
   * @throws Error If a file cannot be fetched or the engine does not start on this device.
   */
  static async start(engine: Engine): Promise<Analyst> {
    const analyst = new Analyst(engine);
    try {
      const { threads } = await analyst.ask({ kind: "start", engine }, "started");
      void navigator.locks?.request(analyst.lock, () => {
        analyst.ended = true;
        analyst.fail("Looking at the picture took more memory than there is. Choose a smaller photo.");
      });
      return Object.assign(analyst, { threads });
    } catch (error) {
      analyst.stop();
      throw error;
    }
  }

  /** Looks at a picture, which is handed over and comes back with the result. */
  async analyse(task: Task): Promise<Analysis> {
    const reply = await this.ask({ kind: "analyse", ...task }, "analysed", [task.picture]);
    return { ...reply.result, prediction: new Prediction(reply.result.prediction) };
  }

  /** A path in the last picture; null if there was none yet. */
  async findPath(goal: Point): Promise<GroundPath | NoPath | null> {
    return (await this.ask({ kind: "path", goal }, "path")).path;
  }

  stop(): void {
    this.waiting.clear(); // nobody is to be told that this one has ended
    this.worker.terminate();
  }

  private ask<K extends Kind>(
    request: Request,
    kind: K,
    transfer: Transferable[] = [],
  ): Promise<ReplyOf<K>> {
    const id = this.asked++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, (reply) => {
        if (reply.kind === "failed") reject(new Error(reply.message));
        else if (reply.kind === kind) resolve(reply as ReplyOf<K>);
        else reject(new Error(`the worker answered ${reply.kind} where ${kind} was asked for`));
      });
      this.worker.postMessage({ id, request } satisfies Asked, transfer);
    });
  }
}
