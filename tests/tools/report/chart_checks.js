// Put behind a page by report_chromium.sh: writes into the body how many of the charts show what they should, data-charts="shown/all",
// and what is wrong with the first that does not. In a frame it posts what is wrong with the page.
addEventListener("load", () => setTimeout(() => {
  const shapes = svg => [...svg.querySelectorAll("path, rect:not(.frame), circle, line:not(.grid, .frame, .cursor), image")];
  // Every shape of a chart lies in it, and at least one is not empty.
  const wrongSvg = svg => {
    const { width, height } = svg.viewBox.baseVal, drawn = shapes(svg);
    if (/NaN|Infinity|undefined/.test(svg.innerHTML)) return "a number is none";
    const inside = box => box.x >= -5 && box.y >= -5 && box.x + box.width <= width + 5 && box.y + box.height <= height + 5;
    if (svg.getClientRects().length === 0) return "";  // in a closed fold
    const outside = [...svg.querySelectorAll("text, path, rect, image, circle")].filter(one => !one.closest("[transform]")).find(one => !inside(one.getBBox()));
    if (outside) return `${outside.tagName} "${outside.textContent || outside.getAttribute("class")}" is cut off`;
    if (!drawn.some(one => one.getBBox().width > 0 || one.getBBox().height > 0)) return "nothing is drawn";
    const unseen = drawn.find(one => { const { fill, stroke } = getComputedStyle(one); return one.tagName !== "image" && fill === "none" && stroke === "none"; });
    if (svg.parentNode.matches(".plot") && !svg.querySelector("image")) {
      const { left, top, width: wide, height: high } = svg.getBoundingClientRect(), tip = svg.parentNode.querySelector(".tip");
      svg.dispatchEvent(new PointerEvent("pointermove", { clientX: left + wide / 2, clientY: top + high / 2 }));
      if (tip.hidden || !/\d/.test(tip.textContent)) return "no value can be read";
      svg.dispatchEvent(new PointerEvent("pointerleave"));
      if (!tip.hidden) return "a value stays";
    }
    return unseen ? `${unseen.getAttribute("class")} has no colour` : "";
  };
  // A picture has ten colours, if it is one of pixels, or those of its lines.
  const coloursOf = (source, width, height) => {
    const pen = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d");
    pen.drawImage(source, 0, 0, width, height);
    const { data } = pen.getImageData(0, 0, width, height), seen = new Set();
    for (let at = 0; at < data.length; at += 4) if (data[at + 3] === 255) seen.add(data[at] << 16 | data[at + 1] << 8 | data[at + 2]);
    return seen;
  };
  const wrongPicture = async (address, width, height) => {
    const picture = new Image();
    await new Promise((good, bad) => Object.assign(picture, { onload: good, onerror: bad, src: address }));
    return coloursOf(picture, width || picture.naturalWidth, height || picture.naturalHeight).size < 10 ? "a picture of less than ten colours" : "";
  };
  (async () => {
    const wrong = [];
    for (const svg of document.querySelectorAll("svg[role=img]")) {
      const text = wrongSvg(svg);
      wrong.push(text && `${text}: ${svg.getAttribute("aria-label")}`);
    }
    for (const image of document.querySelectorAll("svg image")) wrong.push(await wrongPicture(image.getAttribute("href")));
    for (const image of document.querySelectorAll("img")) wrong.push((await wrongPicture(image.src)) && image.alt);
    // The ends of an interval keep their side of 0.
    if (typeof fixed === "function" && fixed(-0.0001, 2) !== "0.00") wrong.push("0 has a minus");
    if (typeof between === "function" && between([-0.0004, 0.0004], 3) !== "\u22120.00040 to 0.00040") wrong.push("an end is rounded to 0");
    const found = wrong.filter(text => text !== "");
    document.body.dataset.charts = `${wrong.length - found.length}/${wrong.length}`;
    if (found.length > 0) document.body.dataset.wrong = found[0];
  })().catch(error => { document.body.dataset.wrong = String(error); }).then(() => {
    const { charts, drawn, error, wrong } = document.body.dataset;
    if (parent !== window) parent.postMessage(error ?? wrong ?? (drawn && !charts.startsWith("0/") ? "none" : "no chart is drawn"), "*");
  });
}, 500));
