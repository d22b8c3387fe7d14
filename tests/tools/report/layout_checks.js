// Put behind a page by report_chromium.sh: posts what is wrong with it.
addEventListener("load", () => setTimeout(() => {
  const found = [], all = query => [...document.querySelectorAll(query)], root = document.documentElement;
  const say = (wrong, text) => { if (wrong) found.push(text); };
  say(root.scrollWidth > innerWidth, "wider than the window: " + root.scrollWidth);
  for (const one of all(".scroll:has(> .answer)")) say(one.scrollWidth > one.clientWidth, "a table of parameters is wider than its page: " + one.scrollWidth);
  const answer = all(".answer tbody tr");
  if (document.querySelectorAll("section").length === 1 && answer.length >= 7)
    say(answer[6].getBoundingClientRect().bottom > 812, "the answer ends at " + answer[6].getBoundingClientRect().bottom);
  say(all("h1").length !== 1, "not one h1");
  let level = 1;
  for (const heading of all("h1, h2, h3, h4")) {
    const own = Number(heading.tagName[1]);
    say(own > level + 1, "h" + own + " after h" + level + ": " + heading.textContent.slice(0, 20));
    level = own;
  }
  for (const one of all("[role=img], canvas, nav, section, [role=region], select, input"))
    say(!(one.getAttribute("aria-label") || one.getAttribute("aria-labelledby") || one.labels?.length), "no name: " + one.tagName);
  for (const one of all("section[aria-labelledby]")) say(!document.getElementById(one.getAttribute("aria-labelledby")), "named by nothing");
  for (const one of all("svg")) say(!one.hasAttribute("aria-hidden") && one.getAttribute("role") !== "img", "an svg without a role");
  for (const one of all("th")) say(!one.hasAttribute("scope"), "th without scope");
  for (const one of all(".tall")) say(one.tabIndex !== 0, "a scrolled table that keys do not reach");
  for (const one of all("details")) say(one.firstElementChild.tagName !== "SUMMARY", "details without summary");
  const light = text => {
    const [r, g, b] = text.match(/[0-9.]+/g).slice(0, 3).map(value => value / 255).map(c => c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const paper = light(getComputedStyle(document.body).backgroundColor), dark = matchMedia("(prefers-color-scheme: dark)").matches;
  say(dark !== paper < 0.2, "paper is not as the system asks");
  say(/, (light|dark)$/.test(name) && dark !== name.endsWith("dark"), "the scheme is not the frame's");
  for (const one of all("h1, .lead, .about, th, td, a, summary, .badge, .warning, .warning li, caption, figcaption")) {
    let below = one;
    while (below !== document.body && /rgba\(.*, 0\)|transparent/.test(getComputedStyle(below).backgroundColor)) below = below.parentElement;
    const ground = getComputedStyle(below).backgroundColor;
    if (ground.startsWith("rgba") || ground.includes("/")) continue;
    const [a, b] = [light(ground), light(getComputedStyle(one).color)].sort((x, y) => y - x);
    say((a + 0.05) / (b + 0.05) < 4.5, "contrast " + ((a + 0.05) / (b + 0.05)).toFixed(2) + " of " + one.tagName + "." + one.className);
  }
  parent.postMessage([...new Set(found)].slice(0, 8).join("; ") || "none", "*");
}, 1000));
