// Fields of the forms of long requests.

import { element } from "./dom.js";
import { numberOf } from "./models.js";

const MOST = 1e6;

/** A field with a number, 0.45, 1/3 or -pi/2; `change` is called with it, or with null where it may be empty; what is none has a sentence. */
export function numberField(label, value, change, { min = -MOST, max = MOST, step = null, mayBeEmpty = false } = {}) {
  const reasonNow = () => (mayBeEmpty && input.value.trim() === "" ? "" : reasonOf(input.value, min, max, step));
  const message = element("small", { class: "fault", role: "alert" });
  const input = element("input", {
    type: "text", class: "number", value: String(value), inputmode: "text", spellcheck: "false", autocomplete: "off",
    title: step === 1 ? `a whole number from ${min} to ${max}` : "a number, such as 0.45, 1/3 or -pi/2",
    oninput: () => {
      // While it is typed a fault is taken back, but none is found.
      if (reasonNow() === "") field.complain("");
    },
    onchange: () => {
      const reason = reasonNow();
      field.complain(reason);
      if (reason === "") change(input.value.trim() === "" ? null : numberOf(input.value));
    },
  });
  // Ends of a narrow range have many digits.
  const widen = () => {
    input.style.minWidth = `${Math.min(18, input.value.length) + 3}ch`;
  };
  input.addEventListener("input", widen);
  widen();
  const field = Object.assign(element("label", {}, element("span", {}, label), input, message), {
    complain(reason) {
      message.textContent = reason;
      input.setAttribute("aria-invalid", reason ? "true" : "false");
    },
  });
  return field;
}

/** Say what is wrong with the text of a field, "" if nothing. */
function reasonOf(text, min, max, step) {
  const number = numberOf(text);
  if (text.trim() === "") return "a number is missing";
  if (!Number.isFinite(number)) return "not a number, such as 0.45, 1/3 or -pi/2";
  if (step === 1 && !Number.isInteger(number)) return `a whole number from ${min} to ${max}`;
  if (number < min || number > max) return `not between ${min} and ${max}`;
  return "";
}

/** Say beside the second of two fields that a range does not go up; tell whether it does. */
export function checkRange(field, low, high) {
  const isRising = low < high;
  field.complain(isRising ? "" : `not above ${low}`);
  return isRising;
}

/** A field that is on or off. */
export function checkField(label, isOn, change) {
  const input = element("input", { type: "checkbox", checked: isOn, onchange: () => change(input.checked) });
  return element("label", { class: "check" }, input, element("span", {}, label));
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
