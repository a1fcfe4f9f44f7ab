// Unpacks the program of the page and runs it. The policy of the page names the digest of its text.
const state = document.getElementById("state");
const say = (text) => {
  if (state.isConnected) state.textContent = text;
};
addEventListener("error", (event) => say(`The viewer stopped: ${event.message}`));
addEventListener("unhandledrejection", (event) => say(`The viewer stopped: ${event.reason?.message ?? event.reason}`));
const bytesOf = (base64) => {
  // Newer browsers decode without a string in between
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(base64);
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < bytes.length; k++) bytes[k] = text.charCodeAt(k);
  return bytes;
};
globalThis.inflate = async (base64) => {
  const bytes = bytesOf(base64);
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
