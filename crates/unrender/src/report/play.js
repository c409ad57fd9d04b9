"use strict";
// The picture under other lamps and colours: whole * S * Q, channel by channel (crate::playable). S is the sum of the
// lamps' shares times their brightness; Q is the greater of one plus the changes by the colours, and of the product of
// their powers. A slider changes the sums by the difference of its own picture alone.

const play = JSON.parse(document.getElementById("play").textContent);
const { width, height } = play;
const count = width * height;
const byId = (id) => document.getElementById(id);

/** The bytes of an element. */
async function unpack(id) {
  const element = byId(id);
  const packed = Uint8Array.from(atob(element.textContent), (c) => c.charCodeAt(0));
  element.remove();
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The codes of a packed picture, channel by channel, and the value of each code. */
async function picture(packed) {
  const bytes = await unpack("p" + packed.id);
  const codes = new Uint16Array(3 * count);
  for (let channel = 0; channel < 3; channel++) {
    const first = channel * count;
    for (let y = 0, at = first; y < height; y++) {
      for (let x = 0; x < width; x++, at++) {
        let prediction = 0;
        if (y === 0) prediction = x === 0 ? 0 : codes[at - 1];
        else if (x === 0) prediction = codes[at - width];
        else {
          const [left, above, corner] = [codes[at - 1], codes[at - width], codes[at - width - 1]];
          if (corner >= Math.max(left, above)) prediction = Math.min(left, above);
          else if (corner <= Math.min(left, above)) prediction = Math.max(left, above);
          else prediction = left + above - corner;
        }
        const zigzag = bytes[at] | (bytes[3 * count + at] << 8);
        codes[at] = prediction + ((zigzag >> 1) ^ -(zigzag & 1));
      }
    }
  }
  const { bits, octaves, max } = packed;
  const values = new Float32Array(1 << bits);
  for (let code = 1; code < values.length; code++) {
    const share = octaves === null ? (code / ((1 << bits) - 1)) ** 2 : 2 ** (((code - 1) / ((1 << bits) - 2) - 1) * octaves);
    values[code] = max * share;
  }
  return { codes, values };
}

/** All values of a picture. */
const decoded = ({ codes, values }) => Float32Array.from(codes, (code) => values[code]);

/** Adds a picture times a factor per channel to `sum`. */
function add(sum, { codes, values }, factor) {
  for (let channel = 0; channel < 3; channel++) {
    const by = factor[channel];
    if (by === 0) continue;
    const scaled = values.map((value) => value * by);
    for (let at = channel * count, end = at + count; at < end; at++) sum[at] += scaled[codes[at]];
  }
}

// sRGB, and codes by the square root of a linear value.
const fromSrgb = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
const toSrgb = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
// The least colour of which powers are taken, as in crate::playable.
const OWN_MIN = 1e-4;
const ROOTS = 4095;
const codeOfRoot = Uint8ClampedArray.from({ length: ROOTS + 1 }, (_, root) => 255 * toSrgb((root / ROOTS) ** 2));
const hexOf = (rgb) => "#" + rgb.map((v) => Math.round(255 * Math.min(Math.max(toSrgb(v), 0), 1)).toString(16).padStart(2, "0")).join("");
const linearOf = (hex) => [1, 3, 5].map((at) => fromSrgb(parseInt(hex.slice(at, at + 2), 16) / 255));
const quoted = (word) => (/^[\w./=+,:-]+$/.test(word) ? word : "'" + word.replaceAll("'", "'\\''") + "'");
const short = (v) => String(Number(v.toPrecision(4)));
const percent = (share) => (100 * share).toPrecision(2) + " %";

async function start() {
  const lamps = [];
  for (const lamp of play.lamps) {
    const first = lamp.on ? [1, 1, 1] : [0, 0, 0];
    lamps.push({ ...lamp, share: await picture(lamp.share), first, brightness: [...first] });
  }
  const colours = [];
  for (const colour of play.colours) {
    const shown = hexOf(colour.now);
    colours.push({ ...colour, response: await picture(colour.response), shown, change: [0, 0, 0] });
  }
  const whole = decoded(await picture(play.whole));
  const photograph = decoded(await picture(play.photograph));
  const map = new Uint16Array((await unpack(play.map)).buffer);

  const light = new Float32Array(3 * count);
  for (const lamp of lamps) add(light, lamp.share, lamp.first);
  // The changes by the colours, of both forms, and what comes of them.
  const [tangent, exponent, change] = [1, 0, 1].map((first) => new Float32Array(3 * count).fill(first));
  // What is multiplied by the light, in values of the photograph: the rendering, or the photograph over its own light.
  const bases = { whole: new Float32Array(3 * count), photograph: new Float32Array(3 * count) };
  for (let channel = 0; channel < 3; channel++) {
    for (let at = channel * count; at < (channel + 1) * count; at++) {
      bases.whole[at] = whole[at] / play.exposure[channel];
      bases.photograph[at] = light[at] > 0 ? photograph[at] / play.exposure[channel] / light[at] : 0;
      photograph[at] /= play.exposure[channel];
    }
  }

  const canvas = byId("picture");
  const context = canvas.getContext("2d");
  const image = context.createImageData(width, height);
  image.data.fill(255);
  let [base, exposure, divider] = ["whole", 1, 0];
  const value = (channel, pixel) => {
    const at = channel * count + pixel;
    return bases[base][at] * light[at] * change[at];
  };
  const paint = () => {
    const from = bases[base];
    const left = Math.round(divider * width);
    for (let channel = 0; channel < 3; channel++) {
      const first = channel * count;
      for (let pixel = 0; pixel < count; pixel++) {
        const linear = from[first + pixel] * light[first + pixel] * change[first + pixel] * exposure;
        image.data[4 * pixel + channel] = codeOfRoot[linear >= 1 ? ROOTS : linear > 0 ? (ROOTS * Math.sqrt(linear) + 0.5) | 0 : 0];
      }
      for (let y = 0; y < height && left > 0; y++) {
        for (let pixel = y * width, end = pixel + left; pixel < end; pixel++) {
          const linear = photograph[first + pixel] * exposure;
          image.data[4 * pixel + channel] = codeOfRoot[Math.min(ROOTS, (ROOTS * Math.sqrt(linear) + 0.5) | 0)];
        }
      }
    }
    context.putImageData(image, 0, 0);
    if (left > 0 && left < width) {
      context.fillStyle = "#fff";
      context.fillRect(left, 0, 1, height);
    }
  };

  // Lamps and colours as they are wanted; the pictures follow with the next frame.
  let due = false;
  const wanted = { lamps: lamps.map((lamp) => lamp.first), colours: colours.map(() => [0, 0, 0]) };
  const follow = () => {
    due = false;
    lamps.forEach((lamp, index) => {
      const to = wanted.lamps[index];
      add(light, lamp.share, to.map((v, c) => v - lamp.brightness[c]));
      lamp.brightness = [...to];
    });
    let changed = false;
    colours.forEach((colour, index) => {
      const [to, from] = [wanted.colours[index], colour.change];
      if (to.every((v, c) => v === from[c])) return;
      changed = true;
      const own = colour.now.map((v) => Math.max(v, OWN_MIN));
      const power = (by) => own.map((v, c) => v * Math.log(Math.max(v + by[c], OWN_MIN) / v));
      const [after, before] = [power(to), power(from)];
      add(tangent, colour.response, to.map((v, c) => v - from[c]));
      add(exponent, colour.response, after.map((v, c) => v - before[c]));
      colour.change = [...to];
    });
    if (changed) {
      const isAsItWas = colours.every((colour) => colour.change.every((v) => v === 0));
      if (isAsItWas) [tangent, change].forEach((all) => all.fill(1)), exponent.fill(0);
      else for (let at = 0; at < 3 * count; at++) change[at] = Math.max(tangent[at], exponent[at] === 0 ? 1 : Math.exp(exponent[at]));
    }
    paint();
    tellErrors();
    tellCommand();
  };
  const later = () => {
    if (!due) requestAnimationFrame(follow);
    due = true;
  };

  const mean = (rgb) => (rgb[0] + rgb[1] + rgb[2]) / 3;
  /** The value at `x` between pairs, and that of the last pair beyond them. */
  const between = (pairs, x) => {
    const after = pairs.findIndex(([at]) => at >= x);
    if (after <= 0) return pairs[after === 0 ? 0 : pairs.length - 1][1];
    const [[x0, y0], [x1, y1]] = [pairs[after - 1], pairs[after]];
    return y0 + ((x - x0) / Math.max(x1 - x0, 1e-9)) * (y1 - y0);
  };
  /** The errors of both approximations, as shares of the mean of the photograph's light. */
  const errors = () => {
    const on = lamps.filter((lamp) => lamp.on);
    const usual = on.length ? on.reduce((sum, lamp) => sum + mean(lamp.brightness), 0) / on.length : 0;
    let shares = 0;
    const roots = [0, 0, 0];
    for (const colour of colours) {
      if (colour.change.every((v) => v === 0)) continue;
      const { first_order: measured, lamps: of } = colour.errors;
      colour.change.forEach((by, c) => (roots[c] += Math.sqrt(between(measured[c], colour.now[c] + by))));
      lamps.forEach((lamp, index) => {
        const off = mean(lamp.brightness.map((v) => Math.abs(v - (lamp.on ? usual : 0))));
        shares += mean(colour.change.map(Math.abs)) * off * of[index];
      });
    }
    return { firstOrder: Math.sqrt(mean(roots.map((root) => root ** 4))), shares };
  };
  const tellErrors = () => {
    const { firstOrder, shares } = errors();
    const isChanged = lamps.some((lamp) => lamp.brightness.some((v, c) => v !== lamp.first[c]));
    byId("errors").textContent = firstOrder === 0 && shares === 0
      ? (isChanged ? "Lamps alone: the page is exact but for noise." : "Nothing is changed yet.")
      : `Errors of about ${percent(firstOrder)} by first order` + (shares > 0 ? ` and ${percent(shares)} by colours under other lamps` : "") +
        " (root mean square, of the mean light of the photograph).";
  };
  const command = () => {
    const words = [play.command];
    for (const lamp of lamps) {
      if (lamp.brightness.every((v, c) => v === lamp.first[c])) continue;
      const all = lamp.brightness.every((v) => v === lamp.brightness[0]);
      const scale = all ? short(lamp.brightness[0]) : `[${lamp.brightness.map(short).join(", ")}]`;
      const isOff = lamp.brightness.every((v) => v === 0);
      words.push("--light " + quoted(isOff ? `${lamp.name}: off` : `${lamp.name}: ${lamp.on ? "" : "on = true, "}scale = ${scale}`));
    }
    for (const colour of colours) {
      if (colour.change.every((v) => v === 0)) continue;
      const to = colour.now.map((v, c) => Math.max(v + colour.change[c], 0));
      const by = colour.key === "tint" ? to.map((v, c) => v / Math.max(colour.now[c], 1e-9)) : to;
      words.push("--repaint " + quoted(`${play.names[colour.group]}: ${colour.key} = [${by.map(short).join(", ")}]`));
    }
    return words.join(" \\\n  ") + " \\\n  --spp 256 --denoise --out new";
  };
  const tellCommand = () => (byId("command").textContent = command());

  // Sliders of lamps: brightness is the square of the place, so that the middle is one.
  const lampRows = [...document.querySelectorAll("[data-lamp]")];
  const ofRow = (row) => {
    const [tint, slider] = [row.querySelector('input[type="color"]'), row.querySelector('input[type="range"]')];
    const factor = slider.value ** 2;
    return linearOf(tint.value).map((v) => v * factor);
  };
  const tellRow = (row) => (row.querySelector("output").textContent = "×" + (row.querySelector('input[type="range"]').value ** 2).toFixed(2));
  const setRow = (row, place, tint = "#ffffff") => {
    row.querySelector('input[type="range"]').value = place;
    row.querySelector('input[type="color"]').value = tint;
    tellRow(row);
    wanted.lamps[lampRows.indexOf(row)] = ofRow(row);
    later();
  };
  lampRows.forEach((row, index) => {
    row.addEventListener("input", () => {
      tellRow(row);
      wanted.lamps[index] = ofRow(row);
      later();
    });
    row.querySelector(".only").addEventListener("click", () => {
      lampRows.forEach((other) => setRow(other, other === row ? 1 : 0));
    });
    tellRow(row);
  });

  const colourRows = [...document.querySelectorAll("[data-colour]")];
  const recolour = (index, hex) => {
    const row = colourRows[index];
    const { shown } = colours[index];
    row.querySelector("input").value = hex;
    row.querySelector(".back").hidden = hex === shown;
    const [to, from] = [linearOf(hex), linearOf(shown)];
    wanted.colours[index] = to.map((v, c) => v - from[c]);
    later();
  };
  colourRows.forEach((row, index) => {
    const field = row.querySelector('input[type="color"]');
    field.value = colours[index].shown;
    field.addEventListener("input", () => recolour(index, field.value));
    row.querySelector(".back").addEventListener("click", () => recolour(index, colours[index].shown));
    row.querySelector(".pick").addEventListener("click", () => choose(colours[index].group));
  });
  byId("as-it-was").addEventListener("click", () => {
    lampRows.forEach((row, index) => setRow(row, play.lamps[index].on ? 1 : 0));
    colourRows.forEach((_, index) => recolour(index, colours[index].shown));
  });

  // Choosing a group.
  const shade = byId("shade").getContext("2d");
  const choose = (group) => {
    const veil = shade.createImageData(width, height);
    for (let pixel = 0; pixel < count; pixel++) veil.data[4 * pixel + 3] = map[pixel] === group ? 0 : 150;
    shade.putImageData(veil, 0, 0);
    setTimeout(() => shade.clearRect(0, 0, width, height), 900);
    colourRows.forEach((row, index) => row.classList.toggle("lit", colours[index].group === group));
    const lit = colourRows.find((_, index) => colours[index].group === group);
    lit?.scrollIntoView({ block: "nearest" });
    byId("chosen").replaceChildren(byId("group-" + group).content.cloneNode(true));
  };

  // Values under the pointer.
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    const x = Math.floor(((event.clientX - box.left) / box.width) * width);
    const y = Math.floor(((event.clientY - box.top) / box.height) * height);
    return x >= 0 && y >= 0 && x < width && y < height ? y * width + x : null;
  };
  const part = (name, text) => {
    const [span, bold] = [document.createElement("span"), document.createElement("strong")];
    bold.textContent = text;
    span.append(name + " ", bold);
    return span;
  };
  const probe = (pixel) => {
    const own = [0, 1, 2].map((channel) => value(channel, pixel));
    const lit = lamps.map((lamp) => [lamp.name, mean([0, 1, 2].map((c) => {
      const at = c * count + pixel;
      return light[at] > 0 ? (lamp.share.values[lamp.share.codes[at]] * lamp.brightness[c]) / light[at] : 0;
    }))]);
    const brightest = lit.filter(([, share]) => share >= 0.005).sort((a, b) => b[1] - a[1]).slice(0, 4);
    byId("probe").replaceChildren(
      part("group", play.names[map[pixel]] ?? "nothing of the model"),
      part("radiance", own.map((v, c) => short(v * play.exposure[c])).join(" ")),
      part("sRGB", own.map((v) => Math.round(255 * Math.min(Math.max(toSrgb(v * exposure), 0), 1))).join(" ")),
      part("lit by", brightest.map(([name, share]) => `${name} ${Math.round(100 * share)} %`).join(", ") || "nothing"),
    );
  };
  canvas.addEventListener("pointermove", (event) => {
    const pixel = place(event);
    if (pixel !== null) probe(pixel);
  });
  canvas.addEventListener("click", (event) => {
    const pixel = place(event);
    if (pixel !== null && map[pixel] !== play.no_group) choose(map[pixel]);
  });

  // The view.
  for (const radio of document.querySelectorAll('input[name="base"]')) {
    radio.addEventListener("change", () => {
      base = radio.value;
      paint();
    });
  }
  byId("divider").addEventListener("input", (event) => {
    divider = event.target.value / 100;
    paint();
  });
  const expose = () => {
    const stops = Number(byId("exposure").value);
    exposure = 2 ** stops;
    byId("stops").textContent = (stops > 0 ? "+" : "") + stops + " EV";
    paint();
  };
  byId("exposure").addEventListener("input", expose);
  const frame = byId("frame");
  let scale = 0;
  const zoom = (to) => {
    scale = to;
    frame.classList.toggle("fit", to === 0);
    frame.style.setProperty("--scale", to);
    byId("zoom").textContent = to === 0 ? "fit" : Math.round(100 * to) + " %";
  };
  const shown = () => scale || Math.max(0.25, canvas.getBoundingClientRect().width / width);
  byId("zoom-in").addEventListener("click", () => zoom(Math.min(16, shown() * 1.5)));
  byId("zoom-out").addEventListener("click", () => zoom(Math.max(0.25, shown() / 1.5)));
  byId("zoom-fit").addEventListener("click", () => zoom(0));
  zoom(0);
  byId("copy").addEventListener("click", async () => {
    await navigator.clipboard.writeText(command()).catch(() => getSelection().selectAllChildren(byId("command")));
    byId("copy").textContent = "Copied";
    setTimeout(() => (byId("copy").textContent = "Copy the command"), 1200);
  });
  expose();
  tellErrors();
  tellCommand();

  // For other scripts: sets a lamp's brightness or a group's colour (linear, per channel) at once, and reads radiance.
  window.unrender = {
    lamp(name, brightness) {
      const index = play.lamps.findIndex((lamp) => lamp.name === name);
      const most = Math.max(...brightness, 1e-9);
      setRow(lampRows[index], Math.sqrt(most), most > 1e-9 ? hexOf(brightness.map((v) => v / most)) : "#ffffff");
      wanted.lamps[index] = brightness;
      follow();
    },
    colour(name, rgb) {
      const index = colours.findIndex((colour) => play.names[colour.group] === name);
      recolour(index, hexOf(rgb));
      wanted.colours[index] = rgb.map((v, c) => v - colours[index].now[c]);
      follow();
    },
    radiance: () => Array.from({ length: count }, (_, pixel) => [0, 1, 2].map((c) => value(c, pixel) * play.exposure[c])),
    errors,
    command,
  };
  document.body.dataset.ready = "true";
}

start().catch((error) => {
  byId("probe").textContent = "This browser cannot show the page (" + error.message + "): use one of 2023 or later.";
});
