// Fields of the long questions.

import { element } from "./dom.js";

/** A field with a number; `change` is called with it. */
export function numberField(label, value, change, attributes = {}) {
  const input = element("input", {
    type: "number", value: String(value), step: "any", ...attributes,
    onchange: () => {
      if (Number.isFinite(input.valueAsNumber)) change(input.valueAsNumber);
    },
  });
  return Object.assign(element("label", {}, element("span", {}, label), input), {
    set(next) {
      input.value = String(next);
    },
  });
}

/** A field with choices [[value, label], …]. */
export function choiceField(label, choices, value, change) {
  const select = element(
    "select",
    { onchange: () => change(select.value) },
    ...choices.map(([name, text]) => element("option", { value: name, selected: name === value }, text)),
  );
  return Object.assign(element("label", {}, element("span", {}, label), select), { select });
}
