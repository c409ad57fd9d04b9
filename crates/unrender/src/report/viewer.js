
// The viewer: one zoom and one exposure for the photograph, the re-rendering and the map of their
// difference, and the values under the pointer.

const SCALE_MAX = 32;
const SCALE_STEP = 1.5;
// The scale at which "Show" shows a place, and the share of the view that an arrow key moves.
const SCALE_SHOWN = 4;
const MOVE = 0.1;

/** Reads pixels of a picture by shares of its width and height; null until it is decoded. */
function pixelsOf(image) {
  if (!image) return () => null;
  let data = null;
  image.decode().then(() => {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.naturalWidth, image.naturalHeight];
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    data = context.getImageData(0, 0, canvas.width, canvas.height);
  });
  return (x, y) => {
    if (!data) return null;
    const [column, row] = [Math.floor(x * data.width), Math.floor(y * data.height)];
    return [...data.data.slice(4 * (row * data.width + column)).slice(0, 3)];
  };
}

function setUpViewer(viewer, number) {
  const frames = [...viewer.querySelectorAll(".frame")];
  const [photo, rerendered] = [".over img", ".layer:not(.over) img"]
    .map((of) => pixelsOf(viewer.querySelector(`.compare ${of}`)));
  const values = pixelsOf(viewer.querySelector(".values"));
  const groups = pixelsOf(document.querySelectorAll(".map .groups")[number]);
  const names = new Map();
  for (const row of document.querySelectorAll("tr[data-color]")) names.set(row.dataset.color, row.dataset.group);
  const probe = viewer.querySelector(".probe");
  const marks = frames.map((frame) => {
    const mark = document.createElement("span");
    mark.className = "mark";
    mark.hidden = true;
    frame.append(mark);
    return mark;
  });

  // What the frames show: the scale, and the place of their upper left corner as shares of the picture.
  let view = { scale: 1, x: 0, y: 0 };
  const show = (scale, x, y) => {
    scale = Math.min(Math.max(scale, 1), SCALE_MAX);
    const within = (at) => Math.min(Math.max(at, 0), 1 - 1 / scale);
    view = { scale, x: within(x), y: within(y) };
    viewer.style.setProperty("--scale", view.scale);
    viewer.style.setProperty("--x", -100 * view.x * view.scale + "%");
    viewer.style.setProperty("--y", -100 * view.y * view.scale + "%");
    viewer.classList.toggle("zoomed", view.scale > 1);
    viewer.classList.toggle("close", view.scale >= SCALE_SHOWN);
    viewer.querySelector(".zoom").textContent = Math.round(100 * view.scale) + " %";
    marks.forEach((mark) => (mark.hidden = true));
  };
  // Changes the scale so that the place (x, y), as shares of the frame, stays where it is.
  const zoom = (factor, x = 0.5, y = 0.5) => {
    const scale = Math.min(Math.max(view.scale * factor, 1), SCALE_MAX);
    show(scale, view.x + x / view.scale - x / scale, view.y + y / view.scale - y / scale);
  };
  const move = (x, y) => show(view.scale, view.x + x / view.scale, view.y + y / view.scale);

  const rgb = (codes) => (codes ? codes.join(" ") : "–");
  const percent = (codes) => {
    if (!codes || codes[0] === 0) return "not compared";
    const root = (codes[0] - 128) / 127;
    const share = 100 * root * Math.abs(root);
    return (share > 0 ? "+" : share < 0 ? "−" : "") + Math.abs(share).toFixed(Math.abs(share) < 1 ? 2 : 1) + " %";
  };
  const group = (codes) => {
    const hex = codes && "#" + codes.map((code) => code.toString(16).padStart(2, "0")).join("");
    return names.get(hex) ?? "nothing of the model";
  };
  // The values at a place of the picture.
  const tell = (x, y) => {
    if (x < 0 || y < 0 || x >= 1 || y >= 1) return;
    const parts = [
      ["photograph", rgb(photo(x, y))],
      ["re-rendering", rgb(rerendered(x, y))],
      ["difference", percent(values(x, y))],
      ["group", group(groups(x, y))],
    ];
    probe.replaceChildren(...parts.map(([name, value]) => {
      const [part, bold] = [document.createElement("span"), document.createElement("strong")];
      bold.textContent = value;
      bold.className = "probe-" + name;
      part.append(name + " ", bold);
      return part;
    }));
    for (const mark of marks) {
      mark.hidden = false;
      mark.style.left = 100 * (x - view.x) * view.scale + "%";
      mark.style.top = 100 * (y - view.y) * view.scale + "%";
    }
  };
  const inFrame = (frame, event) => {
    const box = frame.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };
  const inPicture = ([x, y]) => [view.x + x / view.scale, view.y + y / view.scale];

  for (const frame of frames) {
    const isMap = frame.classList.contains("error");
    let dragged = null;
    frame.addEventListener("pointerdown", (event) => {
      tell(...inPicture(inFrame(frame, event)));
      if (!isMap) return;
      dragged = inFrame(frame, event);
      if (view.scale > 1) frame.setPointerCapture(event.pointerId);
    });
    frame.addEventListener("pointerup", () => (dragged = null));
    frame.addEventListener("pointermove", (event) => {
      const at = inFrame(frame, event);
      if (dragged && event.buttons && view.scale > 1) {
        move(dragged[0] - at[0], dragged[1] - at[1]);
        dragged = at;
      }
      tell(...inPicture(at));
    });
    // A wheel that only passes by scrolls the page.
    frame.addEventListener("wheel", (event) => {
      const zooms = event.ctrlKey || event.metaKey || viewer.contains(document.activeElement);
      const isAtEnd = event.deltaY > 0 ? view.scale <= 1 : view.scale >= SCALE_MAX;
      if (!zooms || (isAtEnd && !event.ctrlKey)) return;
      event.preventDefault();
      zoom(Math.exp(-0.002 * event.deltaY), ...inFrame(frame, event));
    }, { passive: false });
    frame.addEventListener("dblclick", (event) => zoom(SCALE_STEP * SCALE_STEP, ...inFrame(frame, event)));
    frame.addEventListener("keydown", (event) => {
      const arrows = { ArrowLeft: [-MOVE, 0], ArrowRight: [MOVE, 0], ArrowUp: [0, -MOVE], ArrowDown: [0, MOVE] };
      const way = isMap && view.scale > 1 ? arrows[event.key] : undefined;
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.key === "+" || event.key === "=") zoom(SCALE_STEP);
      else if (event.key === "-") zoom(1 / SCALE_STEP);
      else if (event.key === "0") show(1, 0, 0);
      else if (way) move(...way);
      else return;
      event.preventDefault();
      tell(...inPicture([0.5, 0.5]));
    });
  }

  viewer.querySelector(".zoom-in").addEventListener("click", () => zoom(SCALE_STEP));
  viewer.querySelector(".zoom-out").addEventListener("click", () => zoom(1 / SCALE_STEP));
  viewer.querySelector(".zoom-fit").addEventListener("click", () => show(1, 0, 0));

  const exposure = viewer.querySelector(".exposure");
  const expose = () => {
    const stops = Number(exposure.value);
    for (const channel of viewer.querySelectorAll(".filter feComponentTransfer *")) {
      channel.setAttribute("slope", 2 ** stops);
    }
    viewer.style.setProperty("--exposure", stops === 0 ? "none" : `url(#${viewer.dataset.filter})`);
    viewer.querySelector(".stops").textContent = (stops > 0 ? "+" : "") + stops + " EV";
  };
  exposure.addEventListener("input", expose);
  expose();
  show(1, 0, 0);

  for (const button of document.querySelectorAll(`.show[data-viewer="${number}"]`)) {
    button.addEventListener("click", () => {
      const [x, y] = [Number(button.dataset.x), Number(button.dataset.y)];
      show(SCALE_SHOWN, x - 0.5 / SCALE_SHOWN, y - 0.5 / SCALE_SHOWN);
      tell(x, y);
      viewer.scrollIntoView({ block: "start" });
    });
  }
}

document.querySelectorAll(".viewer").forEach(setUpViewer);
