// The page of a design: its motions are mounted as they come near to what is seen; commands are copied.
const motions = JSON.parse(document.getElementById("data").textContent);

function mount(place) {
  if (place.dataset.mounted) return;
  place.dataset.mounted = "yes";
  place.replaceChildren();
  hcsearchPlayer.mount(place, motions[Number(place.dataset.motion)], {});
}

const places = [...document.querySelectorAll(".player")];
const near = new IntersectionObserver((entries) => {
  for (const { isIntersecting, target } of entries) if (isIntersecting) mount(target);
}, { rootMargin: "300px" });
places.forEach((place) => near.observe(place));
addEventListener("beforeprint", () => {
  if (places.every((place) => place.dataset.mounted)) return;
  places.forEach(mount);
  dispatchEvent(new Event("beforeprint")); // again, for the players that were not there: each draws its stills
});

document.addEventListener("click", async (event) => {
  const button = event.target.closest(".copy");
  if (!button) return;
  const code = button.parentElement.querySelector("code");
  try {
    await navigator.clipboard.writeText(code.textContent);
  } catch {
    // Pages opened from a file may be refused the clipboard: select the text instead.
    getSelection().selectAllChildren(code);
    document.execCommand("copy");
  }
  button.textContent = "copied";
  setTimeout(() => { button.textContent = "copy"; }, 1200);
});
