// The report page: its drives become players when they come into view, and "k by hand" its form.

import {startByHand} from '#web/by_hand_form.mjs';
import {Player} from '#web/player.mjs';
import {parse} from '#web/replay.mjs';

const seen = new IntersectionObserver(entries => {
  for (const {isIntersecting, target} of entries) {
    if (!isIntersecting) continue;
    seen.unobserve(target);
    new Player(target, parse(target.parentElement.querySelector('script[type="application/json"]').textContent));
  }
}, {rootMargin: '400px'});

document.documentElement.classList.add('scripted');
for (const place of document.querySelectorAll('.replay .player')) seen.observe(place);
startByHand(document.getElementById('k-by-hand'));
