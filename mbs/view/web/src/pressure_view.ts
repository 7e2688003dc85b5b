// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// What goes with the pressures of surfaces in contact on the motion page: their colour scale, a button and a key.
import { Legend } from './legend';
import type { Mechanism } from './mechanism';
import { stressUnit, toggle } from './ui';

export class PressureView {
  readonly legend = new Legend(true);
  readonly button: HTMLButtonElement;

  constructor(mechanisms: Mechanism[], refresh: () => void) {
    const largest = Math.max(0, ...mechanisms.map((m) => m.pressures.largest));
    const { factor, unit } = stressUnit(largest);
    const show = (on: boolean) => {
      for (const m of mechanisms) m.showPressures = on;
      this.legend.show(on && largest > 0 ? {
        title: `Contact pressure [${unit}]`, scale: 'pressure', low: 0, high: largest * factor, note: 'on the body that touches' } : null);
    };
    // One scale for all runs.
    for (const m of mechanisms) m.pressures.range = largest;
    this.button = toggle('Pressure', true, (on) => {
      show(on);
      refresh();
    }, { title: 'Pressure of surfaces in contact, on the body that touches (O)' });
    this.button.hidden = largest === 0;
    show(true);
  }

  get keys(): { keys: string[]; text: string; run: () => void }[] {
    return this.button.hidden ? [] : [{ keys: ['o'], text: 'pressure of surfaces in contact', run: () => this.button.click() }];
  }
}
