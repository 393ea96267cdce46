// The cards of one page of designs, as the report draws them.
const table = Table.read(JSON.parse(document.getElementById("data").textContent));
const gallery = document.getElementById("gallery"), large = document.getElementById("large");
const cards = Array.from({ length: table.count }, (_, i) => Card.make(table, i));
gallery.append(...cards);

Dialog.listen(table, gallery, large, (i) => Card.fill(table, i, cards[i]));
