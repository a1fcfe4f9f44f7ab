// Unpacks the program of the page and runs it. The policy of the page names the digest of its text.
const state = document.getElementById("state");
const say = (text) => {
  if (state.isConnected) state.textContent = text;
};
addEventListener("error", (event) => say(`The viewer stopped: ${event.message}`));
addEventListener("unhandledrejection", (event) => say(`The viewer stopped: ${event.reason?.message ?? event.reason}`));
globalThis.inflate = async (base64) => {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
};
if (typeof DecompressionStream === "undefined") {
  say("This browser cannot unpack the page. Open it in Firefox 113, Chrome 80, Safari 16.4 or a later version.");
} else {
  globalThis.inflate(document.getElementById("program").textContent).then((bytes) => {
    const script = document.createElement("script");
    script.textContent = new TextDecoder().decode(bytes);
    document.body.append(script);
  });
}
