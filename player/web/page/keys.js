// Keyboard shortcuts: the table of the window (keys.json). A focused control keeps its own keys, and keys that scroll act
// only over the picture.
import table from "../../view/keys.json";

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
    const target = event.target.closest?.("input, select, button, summary, a");
    const isTyped = target && !(target.type === "range" && event.key !== " ") && target.type !== "checkbox";
    if (isTyped && !(event.key === " " && target.type === "range")) return;
    if (target?.type === "checkbox" && event.key === " ") return;
    if (target?.type === "range" && (event.key.startsWith("Arrow") || names[event.key]) && event.key !== " ") return;
    if (scrolling.includes(names[event.key]) && !isOverPicture()) return;
    const action = actions[actionOf(event)];
    if (!action) return;
    action();
    event.preventDefault();
  });
}

/// Lines of help for the page: [keys, meaning].
export const helpLines = [...table.key_help, ...table.mouse_help].filter(([, , where]) => where !== "window");
