// Frames with overlays, and the viewer that enlarges them.
const galleries = JSON.parse(document.getElementById("images").textContent);
const viewer_state = { gallery: null, index: 0 };

const source_of = (frame) => `data:image/jpeg;base64,${frame.jpeg}`;

function gallery_node(gallery) {
  const partly = gallery.frames.length < gallery.available;
  const count = partly ? `${gallery.frames.length} of ${gallery.available} frames (the rest is in the results folder)`
    : `${gallery.frames.length} frames`;
  return el("div", {}, el("h3", {}, gallery.variant, " ", el("small", {}, `seed ${gallery.seed} · ${count}`)),
    el("div", { class: "gallery" }, ...gallery.frames.map((frame, index) =>
      el("button", { type: "button", "aria-label": `Enlarge frame ${frame.frame}`, click: () => show_frame(gallery, index) },
        el("img", { src: source_of(frame), alt: `${gallery.scene}, ${gallery.variant}: frame ${frame.frame} with outlines`, loading: "lazy" })))));
}

// Where the page has no room for a frame of each, it says of which it has none.
function draw_galleries(scene) {
  const of_scene = galleries.filter((g) => g.scene === scene), without = of_scene.filter((g) => g.frames.length === 0).map((g) => g.variant);
  by_id("galleries").replaceChildren(...of_scene.filter((g) => g.frames.length > 0).map(gallery_node),
    ...(without.length ? [el("p", {}, `The page has no room for a frame of ${without.join(", ")}; all are in the results folder.`)] : []));
}

function show_frame(gallery, index) {
  const count = gallery.frames.length;
  Object.assign(viewer_state, { gallery, index: (index + count) % count });
  const frame = gallery.frames[viewer_state.index];
  const viewer = by_id("viewer");
  const image = viewer.querySelector("img");
  image.src = source_of(frame);
  image.alt = `frame ${frame.frame} with outlines`;
  viewer.querySelector("span").textContent = `${gallery.scene} · ${gallery.variant} · frame ${frame.frame}`;
  if (!viewer.open) viewer.showModal();
}

function start_viewer() {
  const viewer = by_id("viewer");
  const step = (by) => show_frame(viewer_state.gallery, viewer_state.index + by);
  for (const button of viewer.querySelectorAll("[data-step]"))
    button.addEventListener("click", () => step(Number(button.dataset.step)));
  viewer.querySelector("[data-close]").addEventListener("click", () => viewer.close());
  viewer.addEventListener("click", (event) => event.target === viewer && viewer.close());
  viewer.addEventListener("keydown", (event) => {
    if (event.key === "ArrowLeft" || event.key === "ArrowRight") step(event.key === "ArrowLeft" ? -1 : 1);
  });
}
