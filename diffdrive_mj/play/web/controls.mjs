// The sliders: a select for robot and maneuver, a slider and a number for everything else.

import { GROUPS, KNOBS, MANEUVERS, idle, nearest, reach } from "./knobs.mjs";
import { compensated, enlightened, rounded } from "./settings.mjs";

export class Controls {
  // `start` is the server's; `changed` is called with the new setting.
  constructor(form, start, changed) {
    Object.assign(this, { form, start, changed, fields: {} });
    form.addEventListener("submit", (event) => event.preventDefault());
    for (const group of GROUPS) form.append(this.group(group));
    const drive = form.firstElementChild;
    drive.querySelector("legend").after(
      this.choice("robot", "Robot", start.settings.map(({ robot }) => [robot, robot])),
      this.choice("maneuver", "Maneuver", start.maneuvers.map((name) => [name, MANEUVERS[name] ?? name])),
    );
  }

  group({ title, names, ghost }) {
    const set = make("fieldset", { className: ghost ? "ghost" : "" }, make("legend", { textContent: title }));
    set.append(...names.map((name) => this.knob(name)));
    if (title === "True robot") {
      set.append(this.button("compensate", ["Fit wheels with r", sub("r"), " = k r", sub("l")], compensated));
    }
    if (ghost) set.append(this.button("enlighten", ["Believe the truth"], enlightened));
    return set;
  }

  button(id, words, change) {
    const button = make("button", { type: "button", id }, ...words);
    button.addEventListener("click", () => this.changed(change(this.setting)));
    return button;
  }

  choice(name, label, options) {
    const made = options.map(([value, textContent]) => make("option", { value, textContent }));
    const select = make("select", { id: name }, ...made);
    select.addEventListener("change", () => {
      const opening = this.start.settings.find(({ robot }) => robot === select.value), { maneuver } = this.setting;
      this.changed(name === "robot" ? { ...opening, maneuver } : { ...this.setting, [name]: select.value });
    });
    this.fields[name] = { select };
    return make("div", { className: "choice" }, make("label", { htmlFor: name, textContent: label }), select);
  }

  knob(name) {
    const { label, unit, steps, help = "" } = KNOBS[name];
    const number = make("input", { type: "number", id: name, step: "any", inputMode: "decimal" });
    const slider = make("input", { type: "range", id: `${name}-slider` });
    slider.setAttribute("aria-label", `${label}, slider`);
    const heard = (value) => this.changed({ ...this.setting, [name]: value });
    slider.addEventListener("input", () => heard(steps ? steps[slider.value] : this.internal(name, slider.value)));
    number.addEventListener("change", () => heard(number.value === "" ? "" : this.internal(name, number.value)));
    const row = make("div", { className: "knob" },
      make("label", { htmlFor: name, textContent: label, title: help }), slider, number,
      make("span", { textContent: unit }));
    this.fields[name] = { number, slider, row };
    return row;
  }

  // From what is shown to SI, without the digits that the factor leaves behind.
  internal(name, shown) {
    return rounded(Number(shown) / (KNOBS[name].scale ?? 1));
  }

  // Show a setting.
  show(setting) {
    this.setting = setting;
    const own = this.start.settings.find(({ robot }) => robot === setting.robot) ?? this.start.settings[0];
    const resting = idle(setting.maneuver);
    for (const [name, { select, number, slider, row }] of Object.entries(this.fields)) {
      if (select) {
        select.value = setting[name];
        continue;
      }
      const { steps, scale = 1 } = KNOBS[name], value = setting[name];
      const shown = typeof value === "number" ? rounded(value * scale) : NaN;
      Object.assign(slider, reach(name, own[name.replace("believed_", "")]));
      slider.value = steps ? nearest(steps, value) : shown;
      if (steps) slider.setAttribute("aria-valuetext", String(value));
      if (Number(number.value) !== shown || number.value === "") number.value = Number.isFinite(shown) ? shown : "";
      row.hidden = resting.includes(name);
    }
    this.form.querySelector("#compensate").hidden = setting.maneuver !== "k";
  }
}

function make(kind, properties, ...children) {
  const made = Object.assign(document.createElement(kind), properties);
  made.append(...children);
  return made;
}

function sub(letter) {
  return make("sub", { textContent: letter });
}
