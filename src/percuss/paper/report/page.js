"use strict";
// Filters the records by the address (?verdict=fails&text=33) and by the form, opens what is linked to, and shows the links to the workbench.
(() => {
  const form = document.querySelector("form.filter");
  const records = [...document.querySelectorAll("details.record")];
  const names = ["verdict", "section", "evidence"];

  function apply() {
    const text = form.elements.text.value.trim().toLowerCase();
    let shown = 0;
    for (const record of records) {
      const fits = names.every((name) => !form.elements[name].value || record.dataset[name] === form.elements[name].value);
      record.hidden = !fits || !record.dataset.text.includes(text);
      shown += !record.hidden;
    }
    form.querySelector("output").textContent = `${shown} of ${records.length}`;
  }

  function read(search) {
    const asked = new URLSearchParams(search);
    for (const name of [...names, "text"]) form.elements[name].value = asked.get(name) ?? "";
    apply();
  }

  function write() {
    const asked = new URLSearchParams();
    for (const name of [...names, "text"]) if (form.elements[name].value) asked.set(name, form.elements[name].value);
    history.replaceState(null, "", `?${asked}`);
    apply();
  }

  function open() {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target?.matches("details")) return;
    if (target.hidden) read("");
    target.open = true;
    target.scrollIntoView();
  }

  if (form) {
    form.hidden = false;
    form.addEventListener("input", write);
    form.addEventListener("submit", (event) => event.preventDefault());
    for (const link of document.querySelectorAll('a[href^="?"]')) {
      link.addEventListener("click", (event) => {
        event.preventDefault();
        const { search, hash } = new URL(link.href);
        history.pushState(null, "", `${search || "?"}${hash}`);
        read(search);
        document.querySelector(hash).scrollIntoView();
      });
    }
    addEventListener("popstate", () => read(location.search));
    read(location.search);
  }
  // Shown by percuss serve, the report stands in the workbench that its links lead to.
  if (location.protocol.startsWith("http") && location.pathname.startsWith("/report/")) {
    for (const link of document.querySelectorAll("a.workbench")) link.hidden = false;
  }
  addEventListener("hashchange", open);
  // A second click on the same link opens the record again.
  addEventListener("click", (event) => {
    const link = event.target.closest?.('a[href^="#"]');
    if (link && link.hash === location.hash) open();
  });
  open();
})();
