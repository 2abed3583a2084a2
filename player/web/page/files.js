// Where a model comes from: the file picker, a drop, or the server that served the page.
import { largestFileMb } from "./seal.js";

const bytesOfMb = 1024 * 1024;

function tooLarge(name, size) {
  return `${name}: the file has ${Math.round(size / bytesOfMb)} MB, wanted at most ${largestFileMb} MB: this page holds it in memory. vrda-player show has no such limit.`;
}

/// `load(bytes, name, isLatest)` for a file that can be read, `complain(message)` for one that cannot. Of files
/// that were asked for one after the other only the last counts, however long each takes to read.
export function watchFiles({ input, overlay, load, complain }) {
  let latest = 0;
  const request = () => {
    const own = ++latest;
    return () => own === latest;
  };
  const open = async (file) => {
    if (!file) return;
    if (file.size > largestFileMb * bytesOfMb) return complain(tooLarge(file.name, file.size));
    const isLatest = request();
    try {
      const bytes = new Uint8Array(await file.arrayBuffer());
      if (isLatest()) await load(bytes, file.name, isLatest);
    } catch (error) {
      if (!isLatest()) return;
      complain(`${file.name}: cannot be read (${error.message})`);
      document.documentElement.dataset.state = "ready";
    }
  };
  input.addEventListener("change", async () => {
    await open(input.files[0]);
    input.value = "";  // so that the same file can be opened again
  });
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
  if (served) fetchModel(served, request(), load, complain);
}

/// Only from the server of the page itself.
async function fetchModel(path, isLatest, load, complain) {
  const address = new URL(path, location.href);
  let name = address.pathname.split("/").at(-1);
  if (address.origin !== location.origin || address.protocol === "file:") return complain(`${name}: found another place, wanted a file of this page's own server`);
  document.documentElement.dataset.state = "loading";
  try {
    const answer = await fetch(address);
    if (!answer.ok) throw new Error(`the server said ${answer.status}`);
    const told = /filename\*=UTF-8''([^;]+)/.exec(answer.headers.get("Content-Disposition") ?? "");
    if (told) name = decodeURIComponent(told[1]);
    const size = Number(answer.headers.get("Content-Length"));
    if (size > largestFileMb * bytesOfMb) throw new Error(tooLarge(name, size));
    const bytes = new Uint8Array(await answer.arrayBuffer());
    if (isLatest()) await load(bytes, name, isLatest);
  } catch (error) {
    if (!isLatest()) return;
    complain(`${name}: cannot be fetched (${error.message})`);
    document.documentElement.dataset.state = "ready";
  }
}
