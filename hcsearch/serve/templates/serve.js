// The cards of one page of designs, as the report draws them.
const table = Table.read(JSON.parse(document.getElementById("data").textContent));
const gallery = document.getElementById("gallery"), large = document.getElementById("large");
const cards = Array.from({ length: table.count }, (_, i) => Card.make(table, i));
gallery.append(...cards);

function chooseFolding(button) {
  const row = Number(button.dataset.row), i = table.foldings.design[row];
  Card.choose(table, row);
  Card.fill(table, i, cards[i]);
  if (large.open) Dialog.show(table, i, large);
  (large.open ? large : gallery).querySelector(`[data-row="${row}"]`)?.focus({ preventScroll: true });
}

document.addEventListener("click", (event) => {
  const button = event.target.closest("button");
  const enlarged = event.target.closest("#gallery .thumb, #gallery .more");
  if (event.target === large || button?.classList.contains("close")) large.close();
  else if (enlarged) Dialog.show(table, Number(enlarged.closest(".card").dataset.index), large);
  else if (!button) return;
  else if (button.dataset.row) chooseFolding(button);
  else if (button.classList.contains("copy")) copy(button);
});
large.addEventListener("close", Dialog.stop);
