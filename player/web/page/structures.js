// The structures of a joint: names, what they do, what is shown of them (schemas/view-state.md), their list and their card.
import { Chart } from "../../../pipeline/report/page/chart.js";
import { formatNumber } from "./readings.js";

// Structures: [{ id, name, does, group, isBundle }]. An id is the path of the group in the motion model and the name there.

export const gapStructure = "layers/gaps", pathsStructure = "layers/contact_paths";

/// The path of a body's group in the motion model.
export const bodyPath = (name) => (["reference", "moving"].includes(name) ? `bodies/${name}` : `followers/${name}/body`);

/// The structure of a component: "femur_shaft" belongs to "femur" if both have one material.
export function structureOf(components, k) {
  const { name, material } = components[k];
  const whole = components.filter((other) => other.material === material && name.startsWith(`${other.name}_`)).map((other) => other.name);
  return whole.sort((a, b) => a.length - b.length)[0] ?? name;
}

// [pattern of the name, name on the page if it differs, what it does]; the first that matches.
const knownBundles = [
  [/^ACLam/i, "ACL, anteromedial", "Keeps the tibia from sliding forwards, most in the bent knee."],
  [/^ACLpl/i, "ACL, posterolateral", "Keeps the tibia from sliding forwards and turning near extension."],
  [/^ACL/i, "Anterior cruciate ligament", "Keeps the tibia from sliding forwards."],
  [/^PCLal/i, "PCL, anterolateral", "Keeps the tibia from sliding backwards, most in the bent knee."],
  [/^PCLpm/i, "PCL, posteromedial", "Keeps the tibia from sliding backwards near extension and in deep flexion."],
  [/^PCL/i, "Posterior cruciate ligament", "Keeps the tibia from sliding backwards."],
  [/^MCLs/i, "MCL, superficial part", "Keeps the knee from opening on the medial side."],
  [/^MCLd/i, "MCL, deep part", "Holds the medial meniscus, and helps to keep the medial side closed."],
  [/^(MCLp|pMC)/i, "Posteromedial capsule", "Keeps the extended knee from opening medially and from bending too far back."],
  [/^MCL/i, "Medial collateral ligament", "Keeps the knee from opening on the medial side."],
  [/^LCL/i, "Lateral collateral ligament", "Keeps the knee from opening on the lateral side."],
  [/^PFL/i, "Popliteofibular ligament", "Keeps the tibia from turning outwards."],
  [/^pCAP/i, "Posterior capsule", "Keeps the knee from bending backwards."],
  [/^(ALL|ITB)/i, "", "Keeps the tibia from turning inwards."],
  [/^PT/i, "Patellar tendon", "Ties the kneecap to the tibia and passes the pull of the quadriceps on."],
  [/^MPFL/i, "Medial patellofemoral ligament", "Keeps the kneecap from slipping laterally."],
  [/^LPFL/i, "Lateral patellofemoral ligament", "Keeps the kneecap from slipping medially."],
  [/^(QUAD|RF|V[ILM])/i, "Quadriceps", "The muscle that straightens the knee; it pulls on the kneecap."],
  [/./, "", "Fibres that resist when the bones move their ends apart."],
];
const knownParts = [
  [/cartilage/i, "", "A smooth layer on bone that lets the joint slide and spreads its load."],
  [/menisc.*(medial|_1)|medial.*menisc/i, "", "A ring of fibrocartilage that spreads the load between femur and tibia."],
  [/menisc/i, "", "A ring of fibrocartilage that spreads the load between femur and tibia."],
  [/femor|femur/i, "", "The thigh bone; at the knee its two condyles roll and slide on the tibia."],
  [/tibia/i, "", "The shin bone; its plateau carries the condyles of the femur."],
  [/fibula/i, "", "The thin bone beside the tibia; the lateral collateral ligament ends on its head."],
  [/patella/i, "", "The kneecap; it gives the quadriceps a longer lever in front of the femur."],
  [/pelvis|acetab/i, "", "The hip bone; its socket holds the head of the femur."],
  [/talus/i, "", "The bone of the ankle between the leg and the heel."],
  [/calcan/i, "", "The heel bone."],
  [/./, "", "A part of this joint."],
];

const known = (table, name) => table.find(([pattern]) => pattern.test(name));

/// "meniscus_medial" is "Medial meniscus", "tibia_cartilage_1" is "Tibia cartilage 1".
function plainName(name) {
  const words = name.replace(/^(\w+)_(medial|lateral)$/, "$2 $1").replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

export function structuresOf(model) {
  const found = new Map(), add = (one) => { if (!found.has(one.id)) found.set(one.id, one); };
  for (const [key, body] of Object.entries(model.bodies)) {
    body.components.forEach(({ material }, k) => {
      const name = structureOf(body.components, k), isSoft = ["cartilage", "meniscus"].includes(material);
      const [, , does] = known(knownParts, material === "cartilage" ? material : name);
      add({ id: `${bodyPath(key)}/${name}`, name: plainName(name), does, group: isSoft ? "Cartilage and menisci" : "Bones" });
    });
  }
  const groups = [["ligaments", model.ligaments], ...model.followers.map(({ name, ligaments }) => [`followers/${name}/ligaments`, ligaments])];
  for (const [path, ligaments] of groups) {
    for (const { bundle } of ligaments?.fibres ?? []) {
      const [, name, does] = known(knownBundles, bundle || "fibres");
      add({ id: `${path}/${bundle}`, name: name || bundle || "Fibres", does, group: "Ligaments", isBundle: true });
    }
  }
  add({ id: gapStructure, name: "Gap map", does: "The distance from the tibia's side to the other bone along the push.", group: "Contact" });
  if (model.contactPaths) add({ id: pathsStructure, name: "Contact paths", does: "Where the bones touch over flexion: medial blue, lateral orange.", group: "Contact" });
  const order = ["Bones", "Cartilage and menisci", "Ligaments", "Contact"];
  return [...found.values()].sort((a, b) => order.indexOf(a.group) - order.indexOf(b.group));
}

// What is shown: plain data, of which only differences from the looks at first are stored.

export const fadedOpacity = 0.2, leastOpacity = 0.1;

export class Looks {
  constructor(structures) {
    this.structures = structures;
    this.highlighted = null;
    this.showAll();
  }

  #first(one) { return { visible: one.group !== "Contact", opacity: 1 }; }

  showAll() { this.byId = new Map(this.structures.map((one) => [one.id, this.#first(one)])); }

  of(id) { return { ...this.byId.get(id), isHighlighted: id === this.highlighted }; }

  change(ids, change) { for (const id of ids) Object.assign(this.byId.get(id), change); }

  /// Changes all structures but `id` and the layers of contact, and shows `id`.
  #changeOthers(id, change) {
    this.change(this.structures.filter((one) => one.id !== id && one.group !== "Contact").map((one) => one.id), change);
    this.change([id], { visible: true, opacity: 1 });
  }

  isolate(id) { this.#changeOthers(id, { visible: false }); }
  fade(id) { this.#changeOthers(id, { visible: true, opacity: fadedOpacity }); }
  hide(id) {
    this.change([id], { visible: false });
    this.highlighted = null;
  }

  get bundles() { return this.structures.filter(({ isBundle }) => isBundle).map(({ id }) => id); }

  /// { id: { visible, opacity } } of what differs from the first looks.
  get data() {
    const data = {};
    for (const one of this.structures) {
      const first = this.#first(one), own = this.byId.get(one.id), different = Object.keys(first).filter((key) => own[key] !== first[key]);
      if (different.length > 0) data[one.id] = Object.fromEntries(different.map((key) => [key, own[key]]));
    }
    return data;
  }

  set data(data) {
    this.showAll();
    for (const [id, look] of Object.entries(data)) this.change([id], look);
  }
}

// The list: a row a structure, with its visibility, name and opacity.

const checkboxIds = { [gapStructure]: "gaps", [pathsStructure]: "paths" };

export class StructureList {
  /// `onChange()` after a change of looks, `onSelect(id)` when a name is chosen.
  constructor(list, { onChange, onSelect }) {
    Object.assign(this, { list, onChange, onSelect });
  }

  show(looks) {
    this.rows = looks.structures.map((one) => {
      const row = document.createElement("li"), shown = Object.assign(document.createElement("input"), { type: "checkbox" });
      const label = document.createElement("label"), name = Object.assign(document.createElement("button"), { type: "button", textContent: one.name });
      const opacity = Object.assign(document.createElement("input"), { type: "range", min: leastOpacity, max: 1, step: 0.05 });
      shown.id = checkboxIds[one.id] ?? "";
      shown.setAttribute("aria-label", `Show: ${one.name}`);
      name.title = one.name;
      opacity.setAttribute("aria-label", `Opacity: ${one.name}`);
      const change = (what) => { looks.change([one.id], what); this.onChange(); };
      shown.addEventListener("change", () => change({ visible: shown.checked }));
      opacity.addEventListener("input", () => change({ opacity: Number(opacity.value) }));
      name.addEventListener("click", () => this.onSelect(looks.highlighted === one.id ? null : one.id));
      label.append(shown);
      row.append(label, name, opacity);
      return { ...one, row, shown, name, opacity };
    });
    const heading = (text) => Object.assign(document.createElement("li"), { className: "heading", textContent: text });
    this.list.replaceChildren(...this.rows.flatMap(({ row, group }, k) => (group === this.rows[k - 1]?.group ? [row] : [heading(group), row])));
    this.update(looks);
  }

  update(looks) {
    for (const { id, row, shown, name, opacity } of this.rows) {
      const look = looks.of(id);
      shown.checked = look.visible;
      opacity.value = look.opacity;
      row.classList.toggle("off", !look.visible);
      name.setAttribute("aria-pressed", String(look.isHighlighted));
    }
  }
}

// The card of the highlighted structure; of a bundle with its strain over flexion.

const percent = (strain) => `${formatNumber(100 * strain, 1)} %`;

/// What the card says of a bundle: its strain and force now, and where it is tightest.
export function readingText({ now, flexion, curve: { x, readings } }) {
  const strains = readings.map((one) => (one ? 100 * one.strain : null)), tightest = strains.indexOf(Math.max(...strains.filter((strain) => strain !== null)));
  if (!now) return "No pose here.";
  const force = `${formatNumber(now.tension, 0)} N`;
  if (now.strain === -1) return `Pulls with ${force} at every angle.`;
  return `${now.strain > 0 ? `Strain ${percent(now.strain)}, ${force}` : `Slack (${percent(now.strain)})`} at ${formatNumber(flexion, 0)}°. ${strains[tightest] > 0 ? "Tightest" : "Never taut; least slack"} at ${formatNumber(x[tightest], 0)}°: ${formatNumber(strains[tightest], 1)} %.`;
}

export class Card {
  /// `byId`: elements of the page; `act(name)`: one of the card's buttons was pressed.
  constructor(byId, act) {
    this.byId = byId;
    this.chart = new Chart(byId("card-curve"));
    for (const button of byId("card").querySelectorAll("button")) button.addEventListener("click", () => act(button.value));
  }

  /// `readings`: of a bundle { now, flexion: its own, curve: { x, readings }, ink }; else undefined.
  show(one, readings) {
    this.byId("card").hidden = !one;
    if (!one) return;
    this.byId("card-name").textContent = one.name;
    this.byId("card-does").textContent = one.does;
    this.byId("card-strain").hidden = this.byId("card-curve").hidden = !readings;
    if (readings) this.#showReadings(readings);
  }

  #showReadings(reading) {
    const { flexion, curve: { x, readings }, ink } = reading, strains = readings.map((one) => (one ? 100 * one.strain : null)), isLine = reading.now?.strain === -1;
    this.byId("card-curve").hidden = isLine;
    this.byId("card-strain").textContent = readingText(reading);
    if (isLine) return;
    this.chart.show({
      ink, x: { title: "flexion, °" }, y: { title: "strain, %" },
      layers: [{ kind: "line", x: [x[0], x.at(-1)], y: [0, 0], colour: ink.quiet, width: 1, dash: [3, 3] },
        { kind: "line", x, y: strains, colour: ink.lines[1], text: (k) => `${formatNumber(strains[k], 1)} % at ${formatNumber(x[k])}°` }, { kind: "upright", x: flexion, colour: ink.text, width: 1 }],
    });
  }
}
