// The words of `hcsearch query`, as store/conditions.py reads them, with two more: `#24`, and words to look for in texts.
const Grammar = (() => {
  const CONDITION = /^([A-Za-z_][A-Za-z_0-9]*)(?:(<=|>=|!=|=|<|>)([^]*)|(?=[()]|$))/;
  const WORDS = ["and", "or", "not"];
  const DEEPEST = 15;

  const escaped = (text) => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");

  // A query with labels of columns, such as `degrees of freedom`, and names in any case, replaced by names, and no space
  // around signs. columns : {name, label}; the longest label that fits is taken. As store/column_labels.py does it.
  function named(query, columns) {
    const names = new Map(columns.flatMap(({ name, label }) => [[label.toLowerCase(), name], [name.toLowerCase(), name]]));
    if (!names.size) return query;
    const any = [...names.keys()].sort((a, b) => b.length - a.length).map((text) => escaped(text).replaceAll(" ", "\\s+")).join("|");
    const tight = query.replace(/(?<!\s)\s*(<=|>=|!=|=|<|>)\s*/g, "$1");
    return tight.replace(new RegExp(`(?<![^\\s(])(?:${any})(?=[<>=!\\s()]|$)`, "gi"),
      (text) => names.get(text.toLowerCase().replace(/\s+/g, " ")));
  }

  // A value up to a bracket that closes what was opened before it.
  function beforeBracket(value) {
    let depth = 0;
    for (let k = 0; k < value.length; k++) {
      depth += { "(": 1, ")": -1 }[value[k]] || 0;
      if (depth < 0) return value.slice(0, k);
    }
    return value;
  }

  // isFlag : whether a name alone is that of a yes/no column; other names alone are words to look for.
  function tokens(query, isFlag) {
    const read = [];
    for (const word of query.split(/\s+/).filter(Boolean)) {
      for (let left = word; left;) {
        if ("()".includes(left[0])) {
          read.push(left[0]);
          left = left.slice(1);
          continue;
        }
        const match = CONDITION.exec(left);
        let text;
        if (match && match[2]) {
          const value = beforeBracket(match[3]);
          text = match[1] + match[2] + value;
          read.push({ kind: "compare", name: match[1], sign: match[2], value, text });
        } else if (match && WORDS.includes(match[1].toLowerCase())) {
          text = match[1];
          read.push(text.toLowerCase());
        } else if (match && isFlag(match[1])) {
          text = match[1];
          read.push({ kind: "flag", name: text, text });
        } else {
          text = beforeBracket(left);
          read.push(/^#\d+$/.test(text) ? { kind: "number", value: Number(text.slice(1)) } : { kind: "text", value: text });
        }
        left = left.slice(text.length);
      }
    }
    return read;
  }

  // Nodes {kind: all | any, parts}, {kind: not, of}, and the conditions; throws Error with a sentence for people.
  function parse(query, isFlag) {
    const left = tokens(query, isFlag).reverse();
    const next = () => left.at(-1);
    const taken = (...words) => words.includes(next()) && Boolean(left.pop());
    const joined = (kind, parts) => (parts.length > 1 ? { kind, parts } : parts[0]);
    const either = (depth) => {
      const parts = [every(depth)];
      while (taken("or")) parts.push(every(depth));
      return joined("any", parts);
    };
    const every = (depth) => {
      const parts = [one(depth)];
      while (taken("and") || ![undefined, ")", "or"].includes(next())) parts.push(one(depth));
      return joined("all", parts);
    };
    const one = (depth) => {
      if (depth > DEEPEST) throw new Error(`more than ${DEEPEST} brackets or “not” inside each other`);
      if (taken("not")) return { kind: "not", of: one(depth + 1) };
      if (taken("(")) {
        const tree = either(depth + 1);
        if (!taken(")")) throw new Error("a bracket is not closed");
        return tree;
      }
      if (typeof next() === "object") return left.pop();
      throw new Error(`a condition is missing ${next() === undefined ? "at the end" : `before “${next()}”`}`);
    };
    if (!left.length) return { kind: "all", parts: [] };
    const tree = either(0);
    if (left.length) throw new Error("a bracket closes where none is open");
    return tree;
  }

  return { named, parse };
})();
