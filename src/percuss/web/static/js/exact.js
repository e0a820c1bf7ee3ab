// Numbers as they were written, as three doubles whose sum is exact to 159 bits: what the kernels take.

const DECIMAL = String.raw`[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?`;
const QUOTIENT = String.raw`[+-]?\d+\/\d+`;
const NUMBER = new RegExp(`^(?:${QUOTIENT}|${DECIMAL})$`);
const PHASE = new RegExp(String.raw`^(?:(${QUOTIENT}|${DECIMAL})(?=[+-]))?([+-]?)(?:(\d+(?:\.\d+|\/\d+)?)\*?)?pi(?:\/(\d+))?$`);
const LONGEST = 60;
// Bits of a quotient before its one rounding to a double.
const BITS = 70;
// Sizes that three doubles hold without loss.
const [LEAST, LARGEST] = [1e-150, 1e150];

/** Return a number, or the text of one, as three doubles; null where the kernels cannot take it. */
export function exactNumber(value) {
  if (Array.isArray(value?.parts)) return value.parts;
  if (typeof value === "number") return isModerate(value) ? [value, 0, 0] : null;
  const ratio = ratioOf(value);
  return ratio === null ? null : parts(ratio);
}

/** Return a phase as {times, plus}, times pi and plus a number; null where it is none. */
export function exactPhase(value) {
  const plain = exactNumber(value);
  if (plain !== null) return { times: [0, 0, 0], plus: plain };
  if (typeof value !== "string" || value.length > LONGEST) return null;
  const match = PHASE.exec(bare(value));
  if (match === null) return null;
  const [, plus, sign, times, over] = match;
  const ratio = ratioOf(times ?? "1");
  const multiple = ratio && [sign === "-" ? -ratio[0] : ratio[0], ratio[1] * BigInt(over ?? 1)];
  const pair = { times: multiple && parts(multiple), plus: exactNumber(plus ?? 0) };
  return pair.times && pair.plus ? pair : null;
}

/** Return the k-th of n values from one double to another, exact; {parts} where it is no end. */
export function exactBetween(low, high, k, n) {
  if (k === 0) return low;
  if (k === n - 1) return high;
  const [first, last] = [ratioOfDouble(low), ratioOfDouble(high)];
  const count = BigInt(n - 1);
  const [a, b] = [first[0] * last[1], last[0] * first[1]];
  return { parts: parts([a * (count - BigInt(k)) + b * BigInt(k), first[1] * last[1] * count]) };
}

/** Return the centre of the k-th of n cells between two doubles, likewise. */
export function centreOf(low, high, k, n) {
  const half = (0.5 * (high - low)) / n;
  return exactBetween(low + half, high - half, k, n);
}

/** Return a double as [numerator, denominator]. */
function ratioOfDouble(value) {
  let denominator = 1n;
  let numerator = value;
  while (!Number.isInteger(numerator)) {
    numerator *= 2;
    denominator *= 2n;
  }
  return [BigInt(numerator), denominator];
}

const isModerate = (value) => value === 0 || (Math.abs(value) >= LEAST && Math.abs(value) <= LARGEST);
const bare = (text) => text.trim().replaceAll(/\s*([-+*/])\s*|(?<=\d)\s+(?=pi)/g, "$1");

/** Return the text of a number as [numerator, denominator], null where it is none. */
function ratioOf(text) {
  if (typeof text !== "string" || text.length > LONGEST || !NUMBER.test(bare(text))) return null;
  const [mantissa, exponent = "0"] = bare(text).toLowerCase().split("e");
  if (mantissa.includes("/")) return mantissa.split("/").map(BigInt);
  const [whole, part = ""] = mantissa.split(".");
  const power = Number(exponent) - part.length;
  const digits = BigInt(whole + part === "" ? 0 : (whole + part).replace("+", ""));
  return power >= 0 ? [digits * 10n ** BigInt(power), 1n] : [digits, 10n ** BigInt(-power)];
}

/** Return a ratio as three doubles, each the nearest to what is left; null beyond their range. */
function parts([numerator, denominator]) {
  if (denominator === 0n) return null;
  const found = [0, 0, 0];
  let [n, d] = [numerator, denominator];
  for (let k = 0; k < 3 && n !== 0n; k += 1) {
    const size = n < 0n ? -n : n;
    const shift = BITS - size.toString(2).length + d.toString(2).length;
    const [top, bottom] = shift >= 0 ? [size << BigInt(shift), d] : [size, d << BigInt(-shift)];
    // The last bit stands for all that is cut off: conversion to a double then rounds once.
    const quotient = (top / bottom) | (top % bottom === 0n ? 0n : 1n);
    const rounded = Number(quotient);
    found[k] = Math.sign(n < 0n ? -1 : 1) * rounded * 2 ** -shift;
    if (k === 0 && !isModerate(found[0])) return null;
    const [taken, over] = shift >= 0 ? [BigInt(rounded), 1n << BigInt(shift)] : [BigInt(rounded) << BigInt(-shift), 1n];
    n = n * over - (n < 0n ? -taken : taken) * d;
    d *= over;
  }
  return found;
}
