/** The device's camera, and clear words where there is none to be had. */

/** A camera that could not be opened; the message says why and what to do, for people. */
export class CameraError extends Error {}

const INSTEAD = "You can choose a photo instead.";

const REASONS: Record<string, string> = {
  NotAllowedError:
    "The camera was not allowed. Allow it in the browser's settings for this page and try again. ",
  NotFoundError: "No camera was found on this device. ",
  OverconstrainedError: "No camera was found on this device. ",
  NotReadableError: "The camera is in use by another program. Close that and try again. ",
};

/** A running camera. */
export class Camera {
  private constructor(
    readonly video: HTMLVideoElement,
    private readonly stream: MediaStream,
  ) {}

  /**
   * Asks for the camera that looks away from the user.
   *
   * @throws CameraError If there is none, it is not allowed, or it is in use.
   */
  static async open(): Promise<Camera> {
    // Pages that are neither from https nor from localhost have no mediaDevices at all.
    if (!isSecureContext || !navigator.mediaDevices) {
      throw new CameraError(
        `The browser gives the camera only to pages opened over https or from localhost. ${INSTEAD}`,
      );
    }
    try {
      const stream = await navigator.mediaDevices.getUserMedia({
        audio: false,
        video: { facingMode: "environment", width: { ideal: 1280 }, height: { ideal: 960 } },
      });
      const video = document.createElement("video");
      Object.assign(video, { srcObject: stream, muted: true, playsInline: true });
      await video.play();
      return new Camera(video, stream);
    } catch (error) {
      const name = error instanceof Error ? error.name : "";
      const reason = REASONS[name] ?? `The camera does not start (${name || String(error)}). `;
      throw new CameraError(reason + INSTEAD);
    }
  }

  /** The next picture; waits while the page is hidden. */
  async nextFrame(): Promise<ImageBitmap> {
    await new Promise((resolve) => this.video.requestVideoFrameCallback(resolve));
    return createImageBitmap(this.video);
  }

  /** Whether the camera was taken away: unplugged, or its permission withdrawn. */
  get ended(): boolean {
    return this.stream.getTracks().every((track) => track.readyState === "ended");
  }

  stop(): void {
    for (const track of this.stream.getTracks()) track.stop();
  }
}
