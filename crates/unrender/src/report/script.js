"use strict";
// The divider, the flicker, the group map and the copy buttons. Without it all pictures, numbers and
// words are still there. The viewer is in viewer.js.

for (const figure of document.querySelectorAll(".compare")) {
  const divider = figure.querySelector(".divider");
  const button = (figure.closest(".viewer") ?? figure).querySelector(".flicker");
  const place = () => figure.style.setProperty("--at", divider.value + "%");
  divider.addEventListener("input", place);
  place();
  let timer = 0;
  const show = (photo) => {
    figure.classList.toggle("photo", photo);
    figure.classList.toggle("rendered", !photo);
  };
  button.addEventListener("click", () => {
    const on = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(on));
    clearInterval(timer);
    figure.classList.remove("photo", "rendered");
    if (on) {
      figure.style.removeProperty("--at");
      show(true);
      timer = setInterval(() => show(!figure.classList.contains("photo")), 700);
    } else {
      place();
    }
  });
}

function setUpMap(figure, number) {
  const image = figure.querySelector(".groups");
  const overlay = figure.querySelector("canvas");
  const readout = figure.querySelector(".readout");
  const rows = new Map();
  for (const row of document.querySelectorAll("tr[data-color]")) rows.set(row.dataset.color, row);
  const photo = document.querySelectorAll(".compare .over img")[number];
  if (photo) {
    const under = photo.cloneNode();
    under.className = "under";
    under.alt = "";
    image.before(under);
  }

  // The colours of the map, read once.
  const plain = document.createElement("canvas");
  const [width, height] = [image.naturalWidth, image.naturalHeight];
  for (const canvas of [plain, overlay]) [canvas.width, canvas.height] = [width, height];
  const context = plain.getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  const pixels = context.getImageData(0, 0, width, height).data;
  const hex = (i) =>
    "#" + [0, 1, 2].map((c) => pixels[4 * i + c].toString(16).padStart(2, "0")).join("");

  let lit = null;
  const light = (row) => {
    if (row === lit) return;
    if (lit) lit.classList.remove("lit");
    lit = row;
    const canvas = overlay.getContext("2d");
    canvas.clearRect(0, 0, width, height);
    if (!row) {
      readout.textContent = "The model shows nothing there.";
      return;
    }
    row.classList.add("lit");
    const shade = canvas.createImageData(width, height);
    const wanted = parseInt(row.dataset.color.slice(1), 16);
    for (let i = 0; i < width * height; i++) {
      const here = (pixels[4 * i] << 16) | (pixels[4 * i + 1] << 8) | pixels[4 * i + 2];
      shade.data[4 * i + 3] = here === wanted ? 0 : 170;
    }
    canvas.putImageData(shade, 0, 0);
    tell(row);
  };
  // Copies of the table's cells, so that each number is in the page once.
  const tell = (row) => {
    const name = document.createElement("strong");
    name.textContent = row.dataset.group;
    const parts = [name];
    for (const head of ["material", "parameters", "error"]) {
      const cell = row.querySelector(`td[data-head="${head}"]`);
      const part = document.createElement("div");
      part.append(...[...cell.childNodes].map((node) => node.cloneNode(true)));
      parts.push(part);
    }
    readout.replaceChildren(...parts);
  };

  // Scrolling moves the page under a resting pointer; that must not choose a group.
  const moved = (act) => (event) => {
    if (event.movementX || event.movementY) act(event);
  };
  const point = (event) => {
    const box = image.getBoundingClientRect();
    const x = Math.floor(((event.clientX - box.left) / box.width) * width);
    const y = Math.floor(((event.clientY - box.top) / box.height) * height);
    if (x < 0 || y < 0 || x >= width || y >= height) return;
    light(rows.get(hex(y * width + x)) ?? null);
  };
  image.addEventListener("pointermove", moved(point));
  image.addEventListener("pointerdown", point);
  for (const row of rows.values()) {
    row.addEventListener("pointermove", moved(() => light(row)));
    row.querySelector(".pick").addEventListener("focus", () => light(row));
    row.querySelector(".pick").addEventListener("click", () => {
      light(row);
      if (number === 0) figure.scrollIntoView({ block: "nearest" });
    });
  }
}

document.querySelectorAll(".map").forEach((figure, number) => {
  const image = figure.querySelector(".groups");
  image.decode().then(() => setUpMap(figure, number));
});

// Pages from a disk may lack the clipboard; then the text is selected and copied.
async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const field = document.createElement("textarea");
    field.value = text;
    document.body.append(field);
    field.select();
    document.execCommand("copy");
    field.remove();
  }
}
for (const button of document.querySelectorAll(".copy")) {
  button.addEventListener("click", async () => {
    await copy(button.dataset.copy);
    button.textContent = "Copied";
    setTimeout(() => (button.textContent = "Copy"), 1200);
  });
}
