// Lessons: steps with a view, a text, an arrow and a question; shown to a student, and made and saved by a teacher.
import { Vector3 } from "three";
import { newLesson } from "./view_state.js";

const element = (name, properties) => Object.assign(document.createElement(name), properties);

/// Shows the steps of a lesson.
export class LessonPlayer {
  /// `host`: useState(state), nameOf(structure), onStep(number), focus().
  constructor(byId, host) {
    Object.assign(this, { byId, host, lesson: null });
    byId("lesson-back").addEventListener("click", () => this.go(this.k - 1));
    byId("lesson-next").addEventListener("click", () => this.go(this.k + 1));
  }

  open(lesson, number) {
    this.lesson = lesson;
    this.go(Math.min(number, lesson.steps.length) - 1);
  }

  close() {
    this.lesson = null;
    this.byId("lesson").hidden = true;
    this.byId("picture").classList.remove("with-lesson");
  }

  get step() { return this.lesson?.steps[this.k]; }
  get number() { return this.lesson && this.k + 1; }
  get isAsking() { return Boolean(this.step?.question) && !this.isAnswered; }

  go(k) {
    const { byId, lesson } = this;
    [this.k, this.isAnswered] = [k, false];
    const { text, question, state } = this.step;
    byId("lesson").hidden = false;
    byId("picture").classList.add("with-lesson");
    byId("lesson-title").textContent = lesson.title;
    byId("lesson-count").textContent = `${k + 1} of ${lesson.steps.length}`;
    byId("lesson-text").textContent = text;
    byId("lesson-ask").textContent = question ? question.ask : "";
    byId("lesson-ask").hidden = !question;
    byId("lesson-answer").textContent = "";
    byId("lesson-back").disabled = k === 0;
    byId("lesson-next").disabled = k + 1 === lesson.steps.length;
    this.host.useState(state);
    this.host.onStep();
  }

  /// An answer by touching a structure.
  answer(structure) {
    const { answers, right, wrong } = this.step.question, isRight = answers.includes(structure);
    this.isAnswered ||= isRight;
    const answer = this.byId("lesson-answer");
    answer.textContent = `${this.host.nameOf(structure)}: ${isRight ? `right. ${right}` : `no. ${wrong}`}`;
    answer.className = isRight ? "right" : "wrong";
  }
}

/// An arrow in the picture to a point of a body.
export class Arrow {
  constructor(svg) { this.svg = svg; }

  /// `arrow` of a step or undefined; `group`: the drawn body, with points relative to the rotation centre; in pane `k` of `n` side by side.
  place(arrow, group, camera, k = 0, n = 1) {
    const place = arrow && group?.visible ? new Vector3(...arrow.point_mm).applyMatrix4(group.matrixWorld).project(camera) : null;
    const isShown = place !== null && Math.abs(place.x) <= 1 && Math.abs(place.y) <= 1 && place.z < 1;
    this.svg.style.visibility = isShown ? "visible" : "hidden";
    if (!isShown) return;
    const { clientWidth, clientHeight } = this.svg.parentElement;
    // From the side on which the picture has more room; the tip is the middle of the drawing.
    this.svg.style.transform = `translate(${(clientWidth * (k + (1 + place.x) / 2)) / n}px, ${(clientHeight * (1 - place.y)) / 2}px) scale(${place.x > 0 ? -1 : 1}, ${place.y > 0.4 ? -1 : 1})`;
  }
}

/// Makes lessons: a list of steps and the fields of one.
export class LessonEditor {
  /// `host`: state(), highlighted(), nameOf(structure), show(steps, k) shows a step, touchPoint() promises an arrow's { body, point_mm },
  /// save(lesson), showError(text).
  constructor(byId, host) {
    Object.assign(this, { byId, host, steps: [], k: -1 });
    const on = (id, event, act) => byId(id).addEventListener(event, act);
    on("teach-add", "click", () => this.#add());
    on("teach-steps", "change", () => this.#choose(byId("teach-steps").selectedIndex));
    on("teach-view", "click", () => this.#change({ state: host.state() }));
    on("teach-text", "input", () => this.#change({ text: byId("teach-text").value }));
    on("teach-remove", "click", () => {
      this.steps.splice(this.k, 1);
      this.#choose(Math.min(this.k, this.steps.length - 1));
    });
    on("teach-arrow", "click", async () => {
      const isOn = byId("teach-arrow").getAttribute("aria-pressed") !== "true";
      byId("teach-arrow").setAttribute("aria-pressed", String(isOn));
      const k = this.k, arrow = isOn ? await host.touchPoint() : undefined;
      if (k === this.k) this.#change({ arrow });
    });
    on("teach-ask", "input", () => this.#question({ ask: byId("teach-ask").value }));
    on("teach-right", "input", () => this.#question({ right: byId("teach-right").value }));
    on("teach-wrong", "input", () => this.#question({ wrong: byId("teach-wrong").value }));
    on("teach-answer", "click", () => {
      const highlighted = host.highlighted(), { answers = [] } = this.steps[this.k].question ?? {};
      if (!highlighted) return host.showError("Answer: found no highlighted structure, wanted the one that is the answer: touch it first.");
      this.#question({ answers: answers.includes(highlighted) ? answers.filter((id) => id !== highlighted) : [...answers, highlighted] });
    });
    on("teach-save", "click", () => {
      const title = byId("teach-title").value.trim() || "Lesson", missing = this.steps.findIndex(({ question }) => question && question.answers.length === 0);
      if (missing >= 0) return host.showError(`Step ${missing + 1}: found a question without an answer, wanted a structure: highlight it and press Answer.`);
      host.save(newLesson(title, this.steps));
    });
    this.#write();
  }

  open({ title, steps }) {
    this.byId("teach-title").value = title;
    this.steps = structuredClone(steps);
    this.k = 0;
    this.#write();
  }

  #add() {
    this.steps.splice(this.k + 1, 0, { text: "", state: this.host.state() });
    ++this.k;
    this.#write();
    this.byId("teach-text").focus();
  }

  #choose(k) {
    this.k = k;
    this.#write();
    if (k >= 0) this.host.useState(this.steps[k].state);
  }

  #change(what) {
    Object.assign(this.steps[this.k], what);
    if (what.arrow === undefined && "arrow" in what) delete this.steps[this.k].arrow;
    this.#write();
  }

  /// A question without a text is removed.
  #question(what) {
    const question = { ask: "", answers: [], right: "", wrong: "", ...this.steps[this.k].question, ...what };
    if (question.ask === "") delete this.steps[this.k].question;
    else this.steps[this.k].question = question;
    this.#write();
  }

  get arrow() { return this.steps[this.k]?.arrow; }

  #write() {
    const { byId, steps, k } = this, step = steps[k], { ask = "", answers = [], right = "", wrong = "" } = step?.question ?? {};
    byId("teach-steps").replaceChildren(...steps.map(({ text }, n) => element("option", { textContent: `${n + 1}: ${text.slice(0, 40) || "(no text)"}`, selected: n === k })));
    for (const [id, value] of [["text", step?.text ?? ""], ["ask", ask], ["right", right], ["wrong", wrong]]) if (byId(`teach-${id}`).value !== value) byId(`teach-${id}`).value = value;
    for (const id of ["text", "view", "remove", "arrow", "ask"]) byId(`teach-${id}`).disabled = !step;
    for (const id of ["answer", "right", "wrong"]) byId(`teach-${id}`).disabled = ask === "";
    byId("teach-save").disabled = steps.length === 0;
    byId("teach-arrow").setAttribute("aria-pressed", String(Boolean(step?.arrow)));
    byId("teach-answers").textContent = answers.length > 0 ? `Answer: ${answers.map((id) => this.host.nameOf(id)).join(", ")}` : "";
    this.host.onChange();
  }
}
