/** Import modules given as [name, text], in order; return the last one. */
async function importTexts(modules) {
  const addresses = new Map();
  let last = null;
  for (const [name, text] of modules) {
    const linked = text.replaceAll(/from "percuss:([^"]+)"/g, (_, other) => `from "${addresses.get(other)}"`);
    const address = URL.createObjectURL(new Blob([linked], { type: "text/javascript" }));
    addresses.set(name, address);
    last = address;
  }
  const module = await import(last);
  for (const address of addresses.values()) URL.revokeObjectURL(address);
  return module;
}
