#include "deploy/muster/report.h"

namespace muster::command {

/// One time, shown everywhere: the slider, the robots and features of both drawings, and a line
/// across the charts.
const char* const kReportScript = R"js(
(() => {
  const run = JSON.parse(document.getElementById('run').textContent);
  const player = document.querySelector('.player');
  if (!player) return;
  const [button, slider, output] = [player.querySelector('button'), player.querySelector('input'), player.querySelector('output')];
  const drawings = [...document.querySelectorAll('.drawing svg')].map(svg => ({
    svg, robots: [...svg.querySelectorAll('.robot')], features: [...svg.querySelectorAll('.feature')]}));
  const cursors = document.querySelectorAll('.cursor');
  const clock = t => { t = Math.round(t); const s = String(t % 60).padStart(2, '0');
    return t < 3600 ? `${Math.floor(t / 60)}:${s}` : `${Math.floor(t / 3600)}:${String(Math.floor(t / 60) % 60).padStart(2, '0')}:${s}`; };
  for (const d of drawings) {
    d.trails = d.robots.map(g => {
      const path = document.createElementNS(d.svg.namespaceURI, 'path');
      path.setAttribute('class', 'trail ' + g.classList[1]);
      d.svg.insertBefore(path, d.robots[0]);
      return path;
    });
  }
  const order = run.robots.map((r, i) => i);

  function where(r, t) {
    let low = 0, high = r.t.length - 1;
    if (high < 0) return null;
    t *= 10;
    while (high - low > 1) { const mid = (low + high) >> 1; if (r.t[mid] <= t) low = mid; else high = mid; }
    const span = r.t[high] - r.t[low];
    const k = span > 0 ? Math.min(1, Math.max(0, (t - r.t[low]) / span)) : 0;
    const mix = a => (a[low] + (a[high] - a[low]) * k) / 10;
    return [mix(r.x), mix(r.y), mix(r.z)];
  }
  // The way it came, for the last 20 s.
  function trail(r, t, elevation) {
    if (t >= run.end) return '';
    const points = [];
    for (let s = Math.max(r.t[0] / 10, t - 20); s < t; s += 0.5) points.push(where(r, s));
    points.push(where(r, t));
    return 'M' + points.map(p => `${p[0].toFixed(2)},${(elevation ? -p[2] : -p[1]).toFixed(2)}`).join(' ');
  }
  const state = (f, t) => f[2] !== null && f[2] <= t ? 'delivered' : f[1] !== null && f[1] <= t ? 'inspected'
    : f[0] !== null && f[0] <= t ? 'found' : 'unseen';

  function show(t) {
    slider.value = t;
    output.textContent = clock(t);
    document.body.classList.toggle('live', t < run.end);
    for (const c of cursors) c.style.left = 100 * t / run.end + '%';
    const places = run.robots.map(r => where(r, t));
    const states = run.features.map(f => state(f, t));
    drawings.forEach((d, elevation) => {
      let drawn = 0;
      for (const i of order) {
        if (!places[i]) continue;
        d.trails[drawn].setAttribute('d', trail(run.robots[i], t, elevation));
        const g = d.robots[drawn++], [x, y, z] = places[i];
        g.setAttribute('transform', `translate(${x} ${elevation ? -z : -y})`);
        g.classList.toggle('lost', run.robots[i].lost !== undefined && run.robots[i].lost <= t);
      }
      d.features.forEach((c, i) => c.setAttribute('class', 'feature ' + states[i]));
    });
  }

  let playing = false, last = 0;
  function frame(now) {
    if (!playing) return;
    const t = Number(slider.value) + Math.min(0.1, (now - last) / 1000) * run.end / 40;  // the whole run in 40 s
    last = now;
    show(Math.min(t, run.end));
    if (t >= run.end) pause(); else requestAnimationFrame(frame);
  }
  function pause() { playing = false; button.textContent = '▶'; button.setAttribute('aria-label', 'Play'); }
  function play() {
    if (Number(slider.value) >= run.end) show(0);
    playing = true; button.textContent = '❚❚'; button.setAttribute('aria-label', 'Pause');
    last = performance.now(); requestAnimationFrame(frame);
  }
  button.onclick = () => playing ? pause() : play();
  slider.oninput = () => { pause(); show(Number(slider.value)); };
  // Pointing at a chart moves the time too.
  for (const element of document.querySelectorAll('.plot, .rows')) {
    const area = element.querySelector('.scrub') || element;
    element.onpointermove = e => {
      const box = area.getBoundingClientRect();
      if (!playing && e.clientX >= box.left) show(Math.min(1, Math.max(0, (e.clientX - box.left) / box.width)) * run.end);
    };
    element.onpointerleave = () => { if (!playing) show(run.end); };
  }
  player.hidden = false;
  show(location.hash.startsWith('#t=') ? Math.min(run.end, Number(location.hash.slice(3)) || 0) : run.end);
})();
)js";

}  // namespace muster::command
