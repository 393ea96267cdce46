// A choice shows the list anew; addresses leave out what is as usual.
const form = document.querySelector("form.tools"), wrong = document.getElementById("wrong"), working = document.getElementById("working");
const usual = { q: "", sort: "", as: "cards", columns: "", scene: form.dataset.usual };

function wait(on) {
  working.hidden = !on;
  document.documentElement.classList.toggle("waiting", on);
}

// What is wrong with the query; empty where the server can read it, or does not answer.
async function faultOf(query) {
  const address = new URL(`${form.action}.json`);
  address.search = new URLSearchParams({ q: query, limit: 0 });
  try {
    const answer = await fetch(address);
    if (answer.status !== 400) return "";
    return new DOMParser().parseFromString(await answer.text(), "text/html").querySelector("main").textContent.trim();
  } catch {
    return "";
  }
}

function send() {
  for (const field of form.elements) field.disabled = usual[field.name] === field.value;
  form.submit();
}

for (const choice of form.querySelectorAll("select")) choice.addEventListener("change", () => form.requestSubmit());
form.addEventListener("submit", async (event) => {
  // What was shown stays, beside what is wrong with the words.
  event.preventDefault();
  wait(true);
  wrong.textContent = form.q.value ? await faultOf(form.q.value) : "";
  if (!wrong.textContent) return send();
  wait(false);
  form.q.setAttribute("aria-invalid", "true");
});
document.addEventListener("click", (event) => {
  const link = event.target.closest("a[href^='/']");
  if (link && !link.hasAttribute("download") && !event.ctrlKey && !event.metaKey && !event.shiftKey) wait(true);
});
document.getElementById("choose").addEventListener("click", () => {
  form.columns.value = [...document.querySelectorAll("#columns input:checked")].map((box) => box.value).join(",");
  form.requestSubmit();
});
// Escape stops a browser from loading.
addEventListener("keydown", (event) => { if (event.key === "Escape") wait(false); });
addEventListener("pageshow", () => {
  wait(false);
  for (const field of form.elements) field.disabled = false;
});
