// The workbench in a notebook cell: anywidget loads import_texts.js and this text as one, and the rest comes with the model.

async function render({ model, el }) {
  const { mount, Requests } = await importTexts(model.get("modules"));
  const files = new Map();
  // A motion may be shown in several cells, each of which hears the answers to all.
  const mine = crypto.getRandomValues(new Uint32Array(1))[0].toString(36);
  let lastFile = 0;
  const requests = new Requests((text) => model.send({ kind: "request", view: mine, text }));
  const take = (message, buffers) => {
    if (message.kind === "frame" && message.view === mine) {
      const view = buffers[0];
      requests.receive(view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength));
    } else if (message.kind === "file") {
      const { resolve, reject } = files.get(message.id) ?? {};
      files.delete(message.id);
      if (message.fault) reject?.(new Error(message.fault));
      else resolve?.({ name: message.name, blob: new Blob([buffers[0]]) });
    }
  };
  model.on("msg:custom", take);
  const file = (extension, request) =>
    new Promise((resolve, reject) => {
      lastFile += 1;
      const id = `${mine}-${lastFile}`;
      files.set(id, { resolve, reject });
      model.send({ kind: "file", id, extension, request });
    });
  const root = document.createElement("div");
  root.classList.add("in-cell");
  // The keys of the notebook are not meant here.
  root.dataset.lmSuppressShortcuts = "true";
  el.append(root);
  let lost;
  const app = mount(root, {
    prefix: `p${mine}`,
    connect: (onState) => {
      lost = () => onState(false);
      model.on("comm_live_update", lost);
      queueMicrotask(() => onState(true));
      return requests;
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
  return () => {
    model.off("msg:custom", take);
    model.off("comm_live_update", lost);
    model.send({ kind: "close", view: mine });
    app.close();
  };
}

export default { render };
