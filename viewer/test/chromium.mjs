// Headless Chromium over a pipe, by the DevTools protocol.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const FLAGS = [
  "--headless", "--no-sandbox", "--remote-debugging-pipe", "--window-size=1280,800", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run",
  "--disable-quic", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--force-device-scale-factor=1", "--hide-scrollbars",
];

/** A browser with one page, which notes errors and requests of the page in `found`. */
export async function start(found) {
  const profile = mkdtempSync(join(tmpdir(), "viewer-"));
  const chromium = spawn(process.env.CHROMIUM ?? "chromium", [...FLAGS, `--user-data-dir=${profile}`], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
  const [into, from] = [chromium.stdio[3], chromium.stdio[4]];
  const waiting = new Map();
  let [count, rest, session] = [0, "", undefined];

  const send = (method, params = {}) => {
    const id = ++count;
    into.write(`${JSON.stringify({ id, method, params, sessionId: session })}\0`);
    return new Promise((done, fail) => waiting.set(id, { done, fail }));
  };
  const receive = ({ id, method, params, result, error }) => {
    if (id) {
      const { done, fail } = waiting.get(id);
      waiting.delete(id);
      return error ? fail(new Error(error.message)) : done(result);
    }
    if (method === "Runtime.exceptionThrown") found.errors.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
    if (method === "Runtime.consoleAPICalled" && ["error", "warning", "assert"].includes(params.type)) found.errors.push(params.args.map((a) => a.value ?? a.description).join(" "));
    // A software renderer says that reading pixels waits for it
    if (method === "Log.entryAdded" && ["error", "warning"].includes(params.entry.level) && !/GPU stall/.test(params.entry.text)) found.errors.push(params.entry.text);
    if (method === "Network.requestWillBeSent" && !/^(blob|data):/.test(params.request.url)) found.requests.push(params.request.url);
  };
  from.setEncoding("utf8").on("data", (text) => {
    const parts = (rest + text).split("\0");
    rest = parts.pop();
    parts.forEach((part) => receive(JSON.parse(part)));
  });
  const { targetId } = await send("Target.createTarget", { url: "about:blank" });
  session = (await send("Target.attachToTarget", { targetId, flatten: true })).sessionId;
  for (const domain of ["Page", "Runtime", "Log", "Network"]) await send(`${domain}.enable`);
  await send("Emulation.setDeviceMetricsOverride", { width: 1280, height: 800, deviceScaleFactor: 1, mobile: false });

  const mouse = (type, [x, y], more = {}) => send("Input.dispatchMouseEvent", { type, x, y, button: "left", clickCount: 1, ...more });
  const touch = (type, points) => send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  return {
    name: "chromium",
    open: (url) => send("Page.navigate", { url }),
    /** The value of a program in the page, which may wait. */
    async run(program) {
      const { result, exceptionDetails } = await send("Runtime.evaluate", { expression: `(async () => { ${program} })()`, awaitPromise: true, returnByValue: true });
      if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
      return result.value;
    },
    /** The window as PNG in base64. */
    picture: async () => (await send("Page.captureScreenshot", { format: "png" })).data,
    async key(key) {
      const text = key.length === 1 ? key : undefined;
      await send("Input.dispatchKeyEvent", { type: "keyDown", key, text });
      await send("Input.dispatchKeyEvent", { type: "keyUp", key });
    },
    async drag(from, to) {
      await mouse("mouseMoved", from, { button: "none" });
      await mouse("mousePressed", from, { buttons: 1 });
      for (const s of [0.5, 1]) await mouse("mouseMoved", [0, 1].map((i) => from[i] + s * (to[i] - from[i])), { buttons: 1 });
      await mouse("mouseReleased", to);
    },
    /** Two fingers from their first to their last places. */
    async pinch(first, last) {
      await touch("touchStart", first);
      for (const s of [0.5, 1]) await touch("touchMove", first.map((p, k) => [0, 1].map((i) => p[i] + s * (last[k][i] - p[i]))));
      await touch("touchEnd", []);
    },
    kill: () => chromium.kill("SIGKILL"),
    async close() {
      // Its processes end together and leave their folder; killed one by one they would still write into it
      const ended = new Promise((done) => chromium.on("exit", done));
      session = undefined;
      send("Browser.close").catch(() => {});
      await Promise.race([ended, new Promise((next) => setTimeout(next, 5000))]);
      chromium.kill("SIGKILL");
      try {
        rmSync(profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 200 });
      } catch (error) {
        console.error(`${profile} is left: ${error.message}`);
      }
    },
  };
}
