// Keyboard shortcuts. A focused control keeps its own keys.

const actions = {
  " ": ({ play }) => play(),
  "[": ({ step }) => step(-1, 0),
  "]": ({ step }) => step(1, 0),
  ";": ({ step }) => step(0, -0.5),
  "'": ({ step }) => step(0, 0.5),
  s: ({ set }) => set(1),
  S: ({ set }) => set(-1),
};

export function watchKeys(player) {
  addEventListener("keydown", (event) => {
    if (!player.isReady() || event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target.closest?.("input, select, button, summary, a");
    const isTyped = target && !(target.type === "range" && event.key !== " ") && target.type !== "checkbox";
    if (isTyped && !(event.key === " " && target.type === "range")) return;
    if (target?.type === "checkbox" && event.key === " ") return;
    const view = Number(event.key) - 1;
    if (Number.isInteger(view) && view >= 0 && view < 6) player.view(view);
    else if (actions[event.key]) actions[event.key](player);
    else return;
    event.preventDefault();
  });
}
