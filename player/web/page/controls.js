// Keys, and the sources of a model.
import table from "../../view/keys.json";
import { largestFileMb } from "./model_file.js";

// Keyboard shortcuts: the table of the window (keys.json). A focused control keeps its own keys, and keys that scroll act
// only over the picture.

const names = { " ": "space", ArrowRight: "right", ArrowLeft: "left", ArrowUp: "up", ArrowDown: "down", PageUp: "page_up", PageDown: "page_down", Home: "home", End: "end", Escape: "escape" };
const scrolling = ["up", "down", "page_up", "page_down", "home", "end"];

/// The action of a key press, or undefined. Function keys belong to the browser.
function actionOf(event) {
  const key = names[event.key] ?? (event.key.length === 1 ? event.key.toUpperCase() : undefined);
  const row = table.keys.find(([name]) => name === key);
  return row && (event.shiftKey && row[2] ? row[2] : row[1]);
}

/// `actions` by name; `isOverPicture()`: whether the pointer or the focus is there.
export function watchKeys(actions, isReady, isOverPicture) {
  addEventListener("keydown", (event) => {
    if (!isReady() || event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target.closest?.("input, select, textarea, button, summary, a");
    const isLeaving = event.key === "Escape" && !target?.matches("select");
    const isTyped = !isLeaving && target && !(target.type === "range" && event.key !== " ") && target.type !== "checkbox";
    if (isTyped && !(event.key === " " && target.type === "range")) return;
    if (target?.type === "checkbox" && event.key === " ") return;
    if (target?.type === "range" && (event.key.startsWith("Arrow") || names[event.key]) && event.key !== " " && !isLeaving) return;
    if (scrolling.includes(names[event.key]) && !isOverPicture()) return;
    const action = actions[actionOf(event)];
    if (!action) return;
    action();
    event.preventDefault();
  });
}

/// Lines of help for the page: [keys, meaning].
export const helpLines = [...table.key_help, ...table.mouse_help].filter(([, , where]) => where !== "window");

// Sources of a model: file picker, drag and drop, or the page's server.

const bytesOfMb = 1024 * 1024;

function tooLarge(name, size) {
  return `${name}: the file has ${Math.round(size / bytesOfMb)} MB, wanted at most ${largestFileMb} MB, since this page holds it in memory. Use vrda-player show for larger files.`;
}

/// Calls `load(bytes, name, isLatest)` for a readable file, otherwise `showError(message)`. Of several requested files only
/// the last counts, regardless of their reading times. A file of the input `other` is for `loadOther`, which is as `load`. `showProgress(text, share)` while one arrives; no share: unknown.
export function watchFiles({ input, other, overlay, load, loadOther, showError, showProgress }) {
  let latest = 0;
  const request = () => {
    const own = ++latest;
    return () => own === latest;
  };
  const open = async (file, use = load) => {
    if (!file) return;
    if (file.size > largestFileMb * bytesOfMb) return showError(tooLarge(file.name, file.size));
    const isLatest = request();
    try {
      const bytes = new Uint8Array(await file.arrayBuffer());
      if (isLatest()) await use(bytes, file.name, isLatest);
    } catch (error) {
      if (!isLatest()) return;
      showError(`${file.name}: cannot be read (${error.message})`);
      document.documentElement.dataset.state = "ready";
    }
  };
  for (const [element, use] of [[input, load], [other, loadOther]]) {
    element.addEventListener("change", async () => {
      await open(element.files[0], use);
      element.value = "";  // allows opening the same file again
    });
  }
  addEventListener("dragover", (event) => {
    event.preventDefault();
    overlay.hidden = false;
  });
  addEventListener("dragleave", (event) => { if (event.relatedTarget === null) overlay.hidden = true; });
  addEventListener("drop", (event) => {
    event.preventDefault();
    overlay.hidden = true;
    open(event.dataTransfer.files[0]);
  });
  const served = new URLSearchParams(location.search).get("model");
  if (served) fetchModel(served, request(), { load, showError, showProgress });
}

/// The body of an answer, with its progress. A compressed one has more bytes than its Content-Length.
async function bytesWithProgress(answer, name, showProgress) {
  const isWhole = !answer.headers.get("Content-Encoding"), size = isWhole ? Number(answer.headers.get("Content-Length")) : 0;
  const pieces = [], reader = answer.body.getReader(), mb = (n) => (n / bytesOfMb).toFixed(1);
  let n = 0;
  for (;;) {
    showProgress(`Loading ${name}: ${mb(n)}${size > 0 ? ` of ${mb(size)}` : ""} MB`, size > 0 ? n / size : undefined);
    const { done, value } = await reader.read();
    if (done) break;
    pieces.push(value);
    n += value.length;
  }
  const bytes = new Uint8Array(n);
  let at = 0;
  for (const piece of pieces) {
    bytes.set(piece, at);
    at += piece.length;
  }
  return bytes;
}

/// Fetches a model, only from the page's own server.
async function fetchModel(path, isLatest, { load, showError, showProgress }) {
  const address = new URL(path, location.href);
  let name = address.pathname.split("/").at(-1);
  if (address.origin !== location.origin || address.protocol === "file:") return showError(`${name}: found another server, wanted a file of this page's own server`);
  document.documentElement.dataset.state = "loading";
  showProgress(`Loading ${name}`);
  try {
    const answer = await fetch(address);
    if (!answer.ok) throw new Error(`server status ${answer.status}`);
    const given = /filename\*=UTF-8''([^;]+)/.exec(answer.headers.get("Content-Disposition") ?? "");
    if (given) name = decodeURIComponent(given[1]);
    const size = Number(answer.headers.get("Content-Length"));
    if (size > largestFileMb * bytesOfMb) throw new Error(tooLarge(name, size));
    const bytes = await bytesWithProgress(answer, name, (text, share) => { if (isLatest()) showProgress(text, share); });
    if (isLatest()) await load(bytes, name, isLatest);
  } catch (error) {
    if (!isLatest()) return;
    showError(`${name}: cannot be fetched (${error.message})`);
    document.documentElement.dataset.state = "ready";
  }
}
