// A choice shows the list anew; addresses leave out what is as usual.
const form = document.querySelector("form.tools");
for (const choice of form.querySelectorAll("select")) choice.addEventListener("change", () => form.requestSubmit());
form.addEventListener("submit", () => {
  for (const field of form.elements) field.disabled = field.name !== "" && ["", "cards", "default"].includes(field.value);
});
addEventListener("pageshow", () => {
  for (const field of form.elements) field.disabled = false;
});
