// The buttons that start augmented and virtual reality, or the reason why they are missing.
import { offeredModes, XrView } from "./xr.js";

const labels = { "immersive-ar": "View in the room", "immersive-vr": "View in VR" };

/// Returns the XrView. `host` as there; `showError(text)`.
export function connectXr(byId, viewer, host, showError) {
  const view = new XrView(viewer, host);
  if (!viewer.renderer) return view;
  if (!window.isSecureContext) byId("xr-note").hidden = false;
  const offer = async () => {
    const modes = await offeredModes();
    byId("xr-buttons").replaceChildren(...modes.map((mode) => {
      const button = Object.assign(document.createElement("button"), { type: "button", value: mode, textContent: labels[mode] });
      button.addEventListener("click", () => {
        button.disabled = true;
        view.start(mode).catch((error) => showError(`${labels[mode]}: ${error.message}`)).finally(() => { button.disabled = false; });
      });
      return button;
    }));
  };
  offer();
  navigator.xr?.addEventListener?.("devicechange", offer);
  return view;
}
