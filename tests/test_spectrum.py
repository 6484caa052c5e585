"""Spectra of quantities in results files."""

import numpy as np
import pytest

from mecano.errors import UnknownNameError, UsageError
from mecano.post.pictures import post
from mecano.post.runs import open_runs
from mecano.post.spectrum import Transforms, Window, amplitudes, densities, density_sheet, spectrum_sheet
from mecano.results.layout import Layout, Series
from mecano.results.provenance import Source
from mecano.results.writer import Writer


def write(path, times, values, axis=None):
    """A file with the force ``values`` of one spring."""
    layout = Layout([Series("elements/spring/force", "N", "force")], **({"axis": axis} if axis else {}))
    with Writer.create(path, layout, Source("mecano: 1\n", {})) as writer:
        for t, value in zip(times, values, strict=True):
            writer.append(t, np.array([value]))
    return path


def sheet(path, text="spring.force"):
    return spectrum_sheet(text, open_runs([path]))


def test_a_sine_has_a_line_as_high_as_its_amplitude():
    """3 sin at 5 Hz and 0.2 cos at 40 Hz over 4 s, all on lines: exact under a Hann window but for rounding."""
    time = 0.01 * np.arange(400)
    values = 7.0 + 3.0 * np.sin(2 * np.pi * 5.0 * time) + 0.2 * np.cos(2 * np.pi * 40.0 * time)
    frequencies, sizes = amplitudes(values, 0.01)
    assert frequencies[0] == pytest.approx(0.25, rel=1e-14) and len(sizes) == 200
    assert sizes[19] == pytest.approx(3.0, rel=1e-12) and sizes[159] == pytest.approx(0.2, rel=1e-12)
    np.testing.assert_allclose(sizes[[18, 20]], 1.5, rtol=1e-12)  # the window spreads a line over its neighbours
    others = np.delete(sizes, [18, 19, 20, 158, 159, 160])
    assert others.max() < 1e-13


def test_between_two_lines_a_sine_appears_15_percent_lower():
    """The loss at half a line is 1 - 8/(3 pi) of a Hann window (Harris 1978, scalloping loss of 1.42 dB)."""
    time = 1e-3 * np.arange(1000)
    sizes = amplitudes(np.sin(2 * np.pi * 50.5 * time), 1e-3)[1]
    assert sizes.max() == pytest.approx(8.0 / (3.0 * np.pi), rel=1e-3)


def test_the_highest_line_of_all_is_half_the_rate_of_saving():
    sizes = amplitudes(0.5 * (-1.0) ** np.arange(64), 0.1)[1]
    assert sizes[-1] == pytest.approx(0.5, rel=1e-12)


def test_the_picture_names_the_peak(tmp_path):
    time = np.append(0.01 * np.arange(200), 1.9931)  # the run ended between two saved times
    path = write(tmp_path / "sine.h5", time, 2.0 * np.sin(2 * np.pi * 10.0 * time))
    shown = sheet(path)
    [panel] = shown.panels
    assert panel.note == "2 N at 10 Hz" and panel.logarithmic and not panel.over_time
    assert "Hann window, mean removed, a line every 0.5 Hz" in shown.heading
    picture, columns = post([path], transforms=Transforms(["spring.force"]), columns=True)
    assert (picture.name, columns.name) == ("sine_spectrum_spring.force.png", "sine_spectrum_spring.force.csv")
    assert columns.read_text().startswith("frequency [Hz],elements.spring.force [N]\n0.5,")


def test_only_the_values_between_two_times(tmp_path):
    """A motion of 2 Hz that ends at 2 s, and a residual vibration of 5 Hz after it, on a line of 2 s."""
    time = 0.01 * np.arange(401)
    force = np.where(time < 2.0, 9.0 * np.sin(4 * np.pi * time), 0.2 * np.sin(10 * np.pi * time))
    path = write(tmp_path / "stop.h5", time, force)
    [panel] = (after := spectrum_sheet("spring.force", open_runs([path]), Window(2.0, 3.99))).panels
    assert after.heading.startswith("Amplitudes over the frequency from 2 s to 3.99 s: Hann")
    assert panel.note == "0.2 N at 5 Hz"
    assert sheet(path).panels[0].note.endswith(" N at 2 Hz")
    [panel] = density_sheet("spring.force", open_runs([path]), Window(begin=2.0)).panels
    assert panel.note.startswith("root mean square 0.14")  # 0.2/sqrt(2)
    with pytest.raises(UsageError, match="has 6 values from 3.95 s: too few"):
        spectrum_sheet("spring.force", open_runs([path]), Window(3.95))
    with pytest.raises(UsageError, match="has 0 values to -1 s: too few"):
        spectrum_sheet("spring.force", open_runs([path]), Window(end=-1.0))
    with pytest.raises(UsageError, match="--from, --to: only with --spectrum or --density"):
        [*post([path], transforms=Transforms(window=Window(1.0)))]


def test_errors_of_spectra(tmp_path):
    time = 0.01 * np.arange(40)
    uneven = write(tmp_path / "uneven.h5", time**2, np.sin(time))
    with pytest.raises(
        UsageError, match=r"uneven.h5 is known at intervals of 0.0001 to 0.0077 s: .* equal intervals.*output"
    ):
        sheet(uneven)
    with pytest.raises(UsageError, match="5 values: too few"):
        sheet(write(tmp_path / "short.h5", time[:5], time[:5]))
    with pytest.raises(UsageError, match="not finite"):
        sheet(write(tmp_path / "nan.h5", time, np.where(time > 0.2, np.nan, 1.0)))
    with pytest.raises(UsageError, match="over the load factor"):
        sheet(write(tmp_path / "static.h5", time, time, Series("load factor", "", "share of the loads")))
    with pytest.raises(UsageError, match="over the frequency"):
        sheet(uneven, "spring.force:spring.force")
    with pytest.raises(UnknownNameError, match="did you mean spring.force"):
        sheet(uneven, "spring.forse")


def test_the_density_of_a_sine_integrates_to_its_mean_square():
    """On a line of the segments, of 2/9 of 1800 values: 3^2/2 under a Hann window, exact but for rounding."""
    time = 0.01 * np.arange(1800)
    frequencies, sizes = densities(7.0 + 3.0 * np.sin(2 * np.pi * 5.0 * time), 0.01)
    assert frequencies[0] == pytest.approx(0.25, rel=1e-14) and len(sizes) == 200
    assert sizes.sum() * 0.25 == pytest.approx(4.5, rel=1e-12)
    assert frequencies[np.argmax(sizes)] == pytest.approx(5.0, rel=1e-14)


def test_white_noise_has_the_same_density_whatever_the_duration():
    """2 s^2/f for the rate f of saving; the mean over all lines has the standard error sqrt(2/n) of a variance."""
    noise = 0.3 * np.random.default_rng(1).standard_normal(2**16)
    for count in (2**13, 2**16):
        frequencies, sizes = densities(noise[:count], 1e-3)
        assert sizes.mean() == pytest.approx(2.0 * 0.09 * 1e-3, rel=3.0 * np.sqrt(2.0 / count))
        halves = [sizes[frequencies < 250.0].mean(), sizes[frequencies > 250.0].mean()]
        assert halves[0] == pytest.approx(halves[1], rel=6.0 * np.sqrt(4.0 / count))


def test_a_road_has_the_density_of_its_deck():
    """ISO 8608: G(n) = 1e-6 (n/0.1)^-2 from 0.5 to 2 per metre; each line scatters, bands of lines do not."""
    x = 0.05 * np.arange(2**15)
    frequencies = np.linspace(0.5, 2.0, 1501)
    phases = np.random.default_rng(2).uniform(0.0, 2 * np.pi, len(frequencies))
    sizes = np.sqrt(2.0 * 1e-6 * (frequencies / 0.1) ** -2.0 * 1e-3)
    height = sum(a * np.cos(2 * np.pi * f * x + p) for a, f, p in zip(sizes, frequencies, phases, strict=True))
    found, density = densities(height, 0.05)
    for low, high in ((0.6, 0.8), (0.9, 1.1), (1.6, 1.9)):
        band = (found > low) & (found < high)
        assert density[band].mean() == pytest.approx((1e-6 * (found[band] / 0.1) ** -2.0).mean(), rel=0.1)


def test_the_picture_of_a_density_names_the_root_mean_square(tmp_path):
    time = 0.01 * np.arange(1800)
    path = write(tmp_path / "sine.h5", time, 2.0 * np.sin(2 * np.pi * 10.0 * time))
    shown = density_sheet("spring.force", open_runs([path]))
    [panel] = shown.panels
    assert panel.note == "root mean square 1.41 N" and panel.curves[0].y.unit == "N2/Hz" and panel.decades
    [picture] = post([path], transforms=Transforms(densities=["spring.force"]))
    assert picture.name == "sine_density_spring.force.png"
    with pytest.raises(UsageError, match="--density 'spring.force:spring.force' is over the frequency"):
        density_sheet("spring.force:spring.force", open_runs([path]))
