// A model and a lesson inside a page: script elements that browsers do not run, before the page's own script.

const modelElement = "model-inside", lessonElement = "lesson-inside";

/// The elements for a page; `base64` of the gzipped model, `lesson` or null.
export function elementsInside({ name, base64, lesson }) {
  const escaped = (text) => text.replace(/[<>&"]/g, (c) => `&#${c.charCodeAt(0)};`);
  const model = `<script type="application/gzip" id="${modelElement}" data-name="${escaped(name)}">${base64}</script>`;
  return lesson ? `${model}\n<script type="application/json" id="${lessonElement}">${JSON.stringify(lesson).replaceAll("<", "\\u003c")}</script>` : model;
}

const throughStream = async (bytes, stream) => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());

async function base64Of(bytes) {
  const zipped = await throughStream(bytes, new CompressionStream("gzip")), size = 0x8000;
  let text = "";
  for (let at = 0; at < zipped.length; at += size) text += String.fromCharCode(...zipped.subarray(at, at + size));
  return btoa(text);
}

/// { name, lesson, bytes() } of what is inside this page, or null.
export function insideOf(page) {
  const model = page.getElementById(modelElement), lesson = page.getElementById(lessonElement);
  if (!model) return null;
  return {
    name: model.dataset.name, lesson: lesson && JSON.parse(lesson.textContent),
    bytes: () => throughStream(Uint8Array.from(atob(model.textContent), (c) => c.charCodeAt(0)), new DecompressionStream("gzip")),
  };
}

/// Takes the page's own text before it changes; returns the function that makes a page with a model and a lesson inside.
export function pageMaker(page) {
  const code = page.currentScript, head = page.head.innerHTML;
  const body = [...page.body.children].filter(({ tagName }) => tagName !== "SCRIPT").map((element) => element.outerHTML).join("\n");
  return async ({ name, bytes, lesson }) => {
    const inside = elementsInside({ name, base64: await base64Of(bytes), lesson });
    return `<!DOCTYPE html>\n<html lang="en">\n<head>${head}</head>\n<body>\n${body}\n${inside}\n<script>${code.textContent}</script>\n</body>\n</html>\n`;
  };
}
