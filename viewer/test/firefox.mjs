// Headless Firefox by the Marionette protocol: JSON over TCP. It draws with WebGL only where a display has it: `xvfb-run -a` gives one.
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { connect } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";

const PREFERENCES = {
  "marionette.port": 0, "webgl.force-enabled": true, "app.update.enabled": false, "browser.shell.checkDefaultBrowser": false, "datareporting.policy.dataSubmissionEnabled": false,
  "toolkit.telemetry.enabled": false, "network.captive-portal-service.enabled": false, "network.connectivity-service.enabled": false, "browser.startup.homepage": "about:blank",
  "services.settings.server": "data:,", "layout.css.devPixelsPerPx": "1.0",
};
const KEYS = { ArrowLeft: "\uE012", ArrowRight: "\uE014", ArrowUp: "\uE013", ArrowDown: "\uE015", Tab: "\uE004" };
const pause = (ms) => new Promise((next) => setTimeout(next, ms));

/** Keeps what the page reports about itself: Marionette has no log. */
const LISTEN = `window.__errors = []; window.addEventListener("error", (e) => __errors.push(e.message)); window.addEventListener("unhandledrejection", (e) => __errors.push(String(e.reason)));`;

export async function start(found) {
  const profile = mkdtempSync(join(tmpdir(), "viewer-"));
  writeFileSync(join(profile, "user.js"), Object.entries(PREFERENCES).map(([k, v]) => `user_pref(${JSON.stringify(k)}, ${JSON.stringify(v)});`).join("\n"));
  const flags = ["--headless", "--marionette", "--no-remote", "--profile", profile, "--width", "1280", "--height", "800"];
  const firefox = spawn(process.env.FIREFOX ?? "firefox-esr", flags, { stdio: "ignore", env: { ...process.env, MOZ_HEADLESS: "1", LIBGL_ALWAYS_SOFTWARE: "1" } });
  const port = join(profile, "MarionetteActivePort");
  for (let k = 0; k < 600 && !existsSync(port); k++) await pause(100);
  const socket = connect(Number(readFileSync(port, "utf8")), "127.0.0.1");
  const waiting = new Map();
  let [count, rest] = [0, Buffer.alloc(0)];
  let greeted;
  const greeting = new Promise((done) => (greeted = done));
  socket.on("data", (bytes) => {
    rest = Buffer.concat([rest, bytes]);
    for (let colon = rest.indexOf(":"); colon >= 0; colon = rest.indexOf(":")) {
      const end = colon + 1 + Number(rest.subarray(0, colon));
      if (rest.length < end) return;
      const message = JSON.parse(rest.subarray(colon + 1, end));
      rest = rest.subarray(end);
      if (!Array.isArray(message)) greeted();
      else {
        const [, id, error, result] = message;
        const { done, fail } = waiting.get(id);
        waiting.delete(id);
        if (error) fail(new Error(error.message));
        else done(result);
      }
    }
  });
  await greeting;
  const send = (command, parameters = {}) => {
    const id = ++count;
    const text = JSON.stringify([0, id, command, parameters]);
    socket.write(`${Buffer.byteLength(text)}:${text}`);
    return new Promise((done, fail) => waiting.set(id, { done, fail }));
  };
  await send("WebDriver:NewSession", { capabilities: { alwaysMatch: { acceptInsecureCerts: false } } });
  await send("WebDriver:SetTimeouts", { script: 280_000, pageLoad: 120_000, implicit: 0 });
  await send("WebDriver:SetWindowRect", { width: 1280, height: 885 });
  const act = (actions) => send("WebDriver:PerformActions", { actions }).then(() => send("WebDriver:ReleaseActions"));
  const move = ([x, y], duration = 0) => ({ type: "pointerMove", x: Math.round(x), y: Math.round(y), duration });
  const finger = (id, kind, from, to) => ({
    type: "pointer", id, parameters: { pointerType: kind },
    actions: [move(from), { type: "pointerDown", button: 0 }, move([0, 1].map((i) => (from[i] + to[i]) / 2), 20), move(to, 20), { type: "pointerUp", button: 0 }],
  });
  const run = async (program) => {
    const script = `const done = arguments[arguments.length - 1]; (async () => { ${program} })().then((value) => done({ value }), (error) => done({ error: String(error.stack ?? error) }));`;
    const { value } = await send("WebDriver:ExecuteAsyncScript", { script, args: [], sandbox: null });
    if (value?.error) throw new Error(value.error);
    return value?.value;
  };
  return {
    name: "firefox",
    async open(url) {
      await send("WebDriver:Navigate", { url });
      await run(LISTEN);
      found.requests.push(url);
    },
    run,
    picture: async () => (await send("WebDriver:TakeScreenshot", { full: false })).value,
    key: (key) => act([{ type: "key", id: "keys", actions: [{ type: "keyDown", value: KEYS[key] ?? key }, { type: "keyUp", value: KEYS[key] ?? key }] }]),
    drag: (from, to) => act([finger("mouse", "mouse", from, to)]),
    pinch: (first, last) => act(first.map((p, k) => finger(`finger ${k}`, "touch", p, last[k]))),
    kill: () => firefox.kill("SIGKILL"),
    async close() {
      found.errors.push(...(await run("return window.__errors ?? []").catch(() => [])));
      const others = await run("return performance.getEntriesByType('resource').map((e) => e.name).filter((n) => !/^(blob|data):/.test(n))").catch(() => []);
      found.requests.push(...others);
      const ended = new Promise((done) => firefox.on("exit", done));
      send("Marionette:Quit", { flags: ["eForceQuit"] }).catch(() => {});
      await Promise.race([ended, pause(10_000)]);
      socket.destroy();
      firefox.kill("SIGKILL");
      rmSync(profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 200 });
    },
  };
}
