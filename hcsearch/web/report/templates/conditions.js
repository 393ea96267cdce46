// Which designs satisfy a query: true, false, or null where a value that counts is not known, as in SQL.
const Conditions = (() => {
  const NUMBER = /^[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?$/;
  const COMPARE = {
    "=": (a, b) => a === b,
    "!=": (a, b) => a !== b,
    "<": (a, b) => a < b,
    "<=": (a, b) => a <= b,
    ">": (a, b) => a > b,
    ">=": (a, b) => a >= b,
  };

  function compared(table, { name, sign, value, text }) {
    if (name.toLowerCase() === Envelopes.NAME) return Envelopes.fitted(table, { sign, value, text });
    const quantity = table.quantity(name);
    if (!quantity) {
      const hint = Nearest.hint(name, table.quantities.map((one) => one.name));
      throw new Error(`no column “${name}”${hint}: see the list under “Words for the box”`);
    }
    if (!value || "=<>!".includes(value[0])) throw new Error(`no value in “${text}”`);
    if (quantity.kind === "text") {
      if (quantity.words.length && "=!=".includes(sign) && !quantity.words.includes(value)) {
        throw new Error(`${name} is never “${value}”${Nearest.hint(value, quantity.words)}: it is one of ${quantity.words.join(", ")}`);
      }
      if (["array", "circuit"].includes(name) && "=!=".includes(sign) && !value.includes(":")) {
        throw new Error(`here ${name}= takes a notation as the cards show it; hcsearch query takes any`);
      }
    } else if (!NUMBER.test(value)) {
      throw new Error(`${name} is compared with ${quantity.kind === "boolean" ? "1 or 0" : "a number"}, not with “${value}”`);
    }
    const wanted = quantity.kind === "text" ? value : Number(value), fits = COMPARE[sign];
    const column = table.designs[name];
    return (i) => (column[i] === null ? null : fits(column[i], wanted));
  }

  function compiled(table, tree) {
    if (tree.kind === "not") {
      const part = compiled(table, tree.of);
      return (i) => { const fits = part(i); return fits === null ? null : !fits; };
    }
    if (tree.kind === "all" || tree.kind === "any") {
      const parts = tree.parts.map((part) => compiled(table, part)), ends = tree.kind === "any";
      return (i) => {
        let unknown = false;
        for (const part of parts) {
          const fits = part(i);
          if (fits === ends) return ends;
          unknown ||= fits === null;
        }
        return unknown ? null : !ends;
      };
    }
    if (tree.kind === "number") return (i) => table.designs.id[i] === tree.value;
    if (tree.kind === "text") {
      if (tree.value === Envelopes.NAME) return Envelopes.fitted(table, { text: tree.value });
      if (table.quantity(tree.value) || /^[<>=!]/.test(tree.value)) {
        throw new Error(`“${tree.value}” alone is no condition: compare it, as in dof<=6`);
      }
      const word = tree.value.toLowerCase();
      return (i) => table.text(i).includes(word);
    }
    if (tree.kind === "flag") return compared(table, { name: tree.name, sign: "=", value: "1", text: tree.name });
    return compared(table, tree);
  }

  // The designs that satisfy a query, in the order of the table; throws Error with a sentence for people.
  function selected(table, query) {
    const isFlag = (name) => table.quantity(name)?.kind === "boolean";
    const fits = compiled(table, Grammar.parse(Grammar.named(query, table.quantities), isFlag));
    return Array.from({ length: table.count }, (_, i) => i).filter((i) => fits(i) === true);
  }

  return { selected };
})();
