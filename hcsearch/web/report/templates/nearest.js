// Names that resemble a misspelt one, by the measure of Ratcliff and Obershelp, as `hcsearch query` suggests them.
const Nearest = (() => {
  const LEAST = 0.6, MOST = 2;

  // Characters of the longest common parts of two texts: the longest one, then those left and right of it.
  function matched(a, b) {
    let [length, from, to] = [0, 0, 0];
    for (let i = 0; i < a.length; i++) {
      for (let j = 0; j < b.length; j++) {
        let k = 0;
        while (i + k < a.length && j + k < b.length && a[i + k] === b[j + k]) k++;
        if (k > length) [length, from, to] = [k, i, j];
      }
    }
    return length && length + matched(a.slice(0, from), b.slice(0, to)) + matched(a.slice(from + length), b.slice(to + length));
  }

  // The part of a message that suggests the nearest names; empty if none is near.
  function hint(word, names) {
    const near = names.map((name) => ({ name, share: (2 * matched(name, word.slice(0, 100))) / (name.length + Math.min(100, word.length)) }))
      .filter(({ share }) => share >= LEAST)
      .sort((a, b) => b.share - a.share || (a.name < b.name ? 1 : -1))
      .slice(0, MOST);
    return near.length ? ` (did you mean ${near.map(({ name }) => name).join(" or ")}?)` : "";
  }

  return { hint };
})();
