// The workbench in a notebook cell: anywidget loads this text, and the rest comes with the model.

/** Import modules given as texts, in order; return the last one. */
async function importTexts(modules) {
  const addresses = new Map();
  let last = null;
  for (const [name, text] of modules) {
    const linked = text.replaceAll(/from "percuss:([^"]+)"/g, (_, other) => `from "${addresses.get(other)}"`);
    const address = URL.createObjectURL(new Blob([linked], { type: "text/javascript" }));
    addresses.set(name, address);
    last = address;
  }
  return import(last);
}

async function render({ model, el }) {
  const { mount, Questions } = await importTexts(model.get("modules"));
  const files = new Map();
  const questions = new Questions((text) => model.send({ kind: "ask", text }));
  const take = (message, buffers) => {
    if (message.kind === "frame") {
      const view = buffers[0];
      questions.receive(view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength));
    } else if (message.kind === "file") {
      const { resolve, reject } = files.get(message.id) ?? {};
      files.delete(message.id);
      if (message.fault) reject?.(new Error(message.fault));
      else resolve?.({ name: message.name, blob: new Blob([buffers[0]]) });
    }
  };
  model.on("msg:custom", take);
  const file = (extension, study) =>
    new Promise((resolve, reject) => {
      const id = crypto.randomUUID();
      files.set(id, { resolve, reject });
      model.send({ kind: "file", id, extension, study });
    });
  const root = document.createElement("div");
  el.append(root);
  mount(root, {
    connect: (onState) => {
      queueMicrotask(() => onState(true));
      return questions;
    },
    facts: model.get("facts"),
    file,
    hasLinks: false,
    study: model.get("study"),
    onStudy: (study) => {
      model.set("study", study);
      model.save_changes();
    },
  });
  return () => model.off("msg:custom", take);
}

export default { render };
