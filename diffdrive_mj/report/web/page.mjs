// The report page: its drives become players when they come into view, and "k by hand" its form.

import {startByHand} from '#web/by_hand_form.mjs';
import {Player} from '#web/player.mjs';
import {parse} from '#web/replay.mjs';

const seen = new IntersectionObserver(entries => {
  for (const {isIntersecting, target} of entries) {
    if (!isIntersecting) continue;
    seen.unobserve(target);
    const replays = target.parentElement.querySelectorAll('script[type="application/json"]');
    new Player(target, [...replays].map(replay => parse(replay.textContent)));
  }
}, {rootMargin: '400px'});

document.documentElement.classList.add('scripted');
for (const place of document.querySelectorAll('.replay .player')) seen.observe(place);
startByHand(document.getElementById('k-by-hand'));
// On paper nothing opens.
let closed = [];
addEventListener('beforeprint', () => {
  closed = [...document.querySelectorAll('details:not([open])')];
  for (const each of closed) each.open = true;
});
addEventListener('afterprint', () => closed.forEach(each => { each.open = false; }));
// From here on everything answers; browsers' tools show it.
performance.mark('usable');
