// The page of a design: its motions are mounted as they come near to what is seen.
const motions = JSON.parse(document.getElementById("data").textContent);

function mount(place) {
  if (place.dataset.mounted) return;
  place.dataset.mounted = "yes";
  place.replaceChildren();
  hcsearchPlayer.mount(place, motions[Number(place.dataset.motion)], { numbers: true });
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

document.addEventListener("click", (event) => {
  const button = event.target.closest(".copy");
  if (button) copy(button);
});
