"""Which part of the body changed? The robot goes on learning, and relearns that part alone.

A change of one part is noticed before anybody can tell which part it was: at first, a longer tool
and a bent upper arm explain the same few samples. So nothing is decided at the alarm. The belief
goes back to before the change, and one copy of it for each candidate c forgets only c,

    C_c = C + E_c Q_c E_c^T,      mean kept                                (`Smoother.forgetting`),

beside one copy that forgets nothing. All learn the samples since the change, one by one, and are
judged by what they predicted of each before they learnt from it,

    e_c = log odds_c + sum_t log p_c(y_t | all before y_t),
    log p = log( exp(-|u|^2 / 2 - log volume) + exp(-gross / 2) ),

u the innovation whitened by its predicted covariance, and the second term what is left for gross
outliers. The first copy to lead all others by a stated number of nats is the belief that goes on;
until then the leading copy answers. Since the copies differ in what they forgot alone, e_c is the
evidence of each explanation, and what was not forgotten stays as well known as it was.

All is a pure transition: the state holds the belief, the test's sums, and the trial, if any.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.huber import gross
from bodyschema.learners.smoother import Foresight, Smoothed, Smoother
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.monitoring.innovations import LONGEST, Candidate, InnovationTest, Sums
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

NOTHING = "nothing"
"""Name of the explanation that no part changed."""


@dataclass(frozen=True)
class Trial:
    """Explanations that compete after an alarm: no change first, then one for each candidate."""

    copies: tuple[Smoothed, ...]
    evidence: Array
    """(n_copies,) nats."""
    samples: int
    """Samples since the change, as it was dated at the alarm."""

    @property
    def leader(self) -> int:
        """Number of the copy with the most evidence."""
        return int(np.argmax(self.evidence))

    @property
    def lead(self) -> float:
        """Nats between the first and the second."""
        second, first = np.sort(self.evidence)[-2:]
        return float(first - second)


@dataclass(frozen=True)
class Watched:
    """State of the monitor."""

    belief: Smoothed
    """In charge: during a trial, the leading copy."""
    test: InnovationTest
    sums: Sums
    trial: Trial | None = None

    @property
    def estimate(self) -> Estimate:
        """The belief in the form of every learner's result."""
        return self.belief.estimate

    @property
    def body(self) -> Body:
        """The body as believed now."""
        return self.belief.body


@dataclass(frozen=True)
class Report:
    """What the monitor has to say about one sample."""

    seen: Foresight
    ratio: float
    """Largest test statistic over the alarm level; 0 during a trial."""
    alarm: bool = False
    """Something changed, as of this sample; a trial begins."""
    suspect: str = ""
    """During a trial, the leading explanation."""
    verdict: str = ""
    """At the end of a trial, what changed: a candidate's name, or "nothing"."""


@dataclass(frozen=True)
class LinkMonitor:
    """A learner that notices which part changed and learns that part anew."""

    candidates: tuple[Candidate, ...]
    learner: Smoother = field(default_factory=Smoother)
    chance: float = 3e-7
    """See `InnovationTest.of`; less than one false alarm in 1e5 samples, by simulation."""
    lead: float = 8.0
    """Nats by which an explanation must lead."""
    least: int = 5
    """Samples since the change before anything is decided."""
    longest: int = 300
    """Samples after which the leader wins however small its lead."""

    def start(self, body: Body, variables: Variables) -> Watched:
        """The prior belief, before the first sample.

        Raises:
            InputError: a candidate has a parameter that is not learnt, or the learner's window is
                shorter than the longest window of the test.
        """
        if self.learner.lag < LONGEST:
            raise InputError(
                f"the window of the learner has {self.learner.lag} samples; a change is looked for "
                f"in the last {LONGEST}, so give it at least as many."
            )
        test = InnovationTest.of(self.candidates, variables, self.chance)
        return Watched(self.learner.start(body, variables), test, test.start())

    def step(self, state: Watched, sample: Sense) -> tuple[Watched, Report]:
        """Learn from one sample (a batch of one), and watch."""
        if state.trial is not None:
            return self._try(state, state.trial, sample)
        settled = len(state.belief.window) >= self.learner.lag
        belief, seen = self.learner.step(state.belief, sample)
        if not settled:
            # A belief that began with an outlier is as surprised as one whose body has changed.
            return replace(state, belief=belief), Report(seen, 0.0)
        sums, finding = state.test.step(state.sums, seen)
        if finding.ratio < 1:
            return replace(state, belief=belief, sums=sums), Report(seen, finding.ratio)
        trial = self._opened(belief, finding.window)
        report = Report(seen, finding.ratio, True, self._name(trial.leader))
        return replace(state, belief=trial.copies[trial.leader], sums=sums, trial=trial), report

    def _opened(self, belief: Smoothed, window: int) -> Trial:
        """The explanations as of the change, which then learn all that came since."""
        base, since = self.learner.before(belief, window)
        copies = [self.learner.absorbing(base)]
        for candidate in self.candidates:
            rows = candidate.rows(belief.variables)
            copies.append(self.learner.forgetting(base, rows, np.full(len(rows), candidate.spread)))
        odds = np.log([1.0, *(candidate.odds for candidate in self.candidates)])
        trial = Trial(tuple(copies), odds, 0)
        for sample in since:
            trial, _ = self._judged(trial, sample)
        return trial

    def _judged(self, trial: Trial, sample: Sense) -> tuple[Trial, list[Foresight]]:
        """Each copy predicts the sample, is judged by that, and learns from it."""
        steps = [self.learner.step(copy, sample) for copy in trial.copies]
        seen = [foresight for _, foresight in steps]
        evidence = trial.evidence + [log_likelihood(foresight) for foresight in seen]
        return Trial(tuple(copy for copy, _ in steps), evidence, trial.samples + 1), seen

    def _try(self, state: Watched, trial: Trial, sample: Sense) -> tuple[Watched, Report]:
        """One more sample for all explanations; decide when one leads."""
        after, seen = self._judged(trial, sample)
        foresight, name = seen[trial.leader], self._name(after.leader)
        belief = after.copies[after.leader]
        clear = after.samples >= self.least and after.lead >= self.lead
        if clear or after.samples >= self.longest:
            settled = Watched(belief, state.test, state.test.start())
            return settled, Report(foresight, 0.0, verdict=name)
        return replace(state, belief=belief, trial=after), Report(foresight, 0.0, suspect=name)

    def _name(self, copy: int) -> str:
        return self.candidates[copy - 1].name if copy else NOTHING


def log_likelihood(seen: Foresight) -> float:
    """Nats of a sample under the belief that foresaw it, bounded from below for outliers."""
    normal = -seen.surprise / 2 - seen.log_volume
    return float(np.logaddexp(normal, -gross(len(seen.innovation)) / 2))
