"""Andrews' squeezing mechanism (inputs/andrews.yaml) against the test set for initial value problem solvers."""

from time_runs import RecordedRun, input_deck

# Mazzia & Magherini, Test Set for Initial Value Problem Solvers, release 2.4, Bari 2008, problem "Andrews' squeezing
# mechanism": angles [rad] at the start and at 0.03 s
START = {
    "beta": -0.0617138900142764496, "theta": 0.0, "gamma": 0.455279819163070380, "phi": 0.222668390165885885,
    "delta": 0.487364979543842550, "omega": -0.222668390165885885, "epsilon": 1.23054744454982119,
}  # fmt: skip
END = {
    "beta": 15.8107711962990, "theta": -15.7563710598430, "gamma": 0.0408222401307310, "phi": -0.534730116322695,
    "delta": 0.524409965880530, "omega": 0.534730116322695, "epsilon": 1.04808074104226,
}  # fmt: skip


def test_the_squeezing_mechanism_meets_the_published_solution(verify):
    """Within the tolerance of 1e-8 of the deck; the crank turns by 15.9 rad."""
    recorded = RecordedRun(input_deck("andrews"))
    for name, end in END.items():
        angle = START[name] + recorded[f"joints/{name}/angle"][-1]
        verify("Joints", f"Andrews' mechanism: {name} [rad]", angle, end, "IVP test set", absolute=1e-8)
    assert recorded.run.steps < 1000
