// A choice shows the list anew; addresses leave out what is as usual.
const form = document.querySelector("form.tools");
for (const choice of form.querySelectorAll("select")) choice.addEventListener("change", () => form.requestSubmit());
form.addEventListener("submit", () => {
  const usual = { q: "", sort: "", as: "cards", scene: form.dataset.usual };
  for (const field of form.elements) field.disabled = usual[field.name] === field.value;
});
addEventListener("pageshow", () => {
  for (const field of form.elements) field.disabled = false;
});
