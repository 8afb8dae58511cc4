/**
 * Keeps the page on the device after the first visit, and hands it out with the headers that
 * threads need, on servers that cannot send them: from the second visit on.
 */

// Filled in by the build: see vite.config.ts.
const FILES = "%FILES%" as unknown as string[];
const CACHE = "footprints-%VERSION%";

const worker = self as unknown as ServiceWorkerGlobalScope;

worker.addEventListener("install", (event) => {
  event.waitUntil(
    caches.open(CACHE).then((cache) =>
      // Past the browser's own cache: a version is whole, or it is not there.
      cache.addAll(FILES.map((file) => new Request(file, { cache: "no-cache" }))),
    ),
  );
});

worker.addEventListener("activate", (event) => {
  event.waitUntil(
    caches
      .keys()
      .then((names) =>
        Promise.all(
          names
            .filter((name) => name.startsWith("footprints-") && name !== CACHE)
            .map((name) => caches.delete(name)),
        ),
      )
      .then(() => worker.clients.claim()),
  );
});

worker.addEventListener("fetch", (event) => {
  const { request } = event;
  const url = new URL(request.url);
  if (request.method === "GET" && url.origin === worker.location.origin) {
    event.respondWith(answer(request, url));
  }
});

async function answer(request: Request, url: URL): Promise<Response> {
  const cache = await caches.open(CACHE);
  const file = url.pathname.endsWith("/") ? new URL("index.html", url) : request;
  const kept = await cache.match(file, { ignoreSearch: true, ignoreVary: true });
  if (kept) return isolated(kept);
  const fetched = await fetch(request);
  if (fetched.type !== "basic") return fetched; // a redirect, which the browser follows by itself
  if (fetched.status === 200) await cache.put(request, fetched.clone());
  return isolated(fetched);
}

/** The same response, with the headers for cross-origin isolation. */
function isolated(response: Response): Response {
  const headers = new Headers(response.headers);
  headers.set("Cross-Origin-Opener-Policy", "same-origin");
  headers.set("Cross-Origin-Embedder-Policy", "require-corp");
  headers.set("Cross-Origin-Resource-Policy", "same-origin");
  return new Response(response.body, {
    status: response.status,
    statusText: response.statusText,
    headers,
  });
}

export {};
