"""Which sockets an FMU fits."""

from __future__ import annotations

from orchestrator.exchange.passport import fit_lines
from orchestrator.mapping.mapping_reader import read_mapping
from orchestrator.system.source import Fmu
from tests.orchestrator import foreign
from tests.orchestrator.exchange.passport.measured_fmus import lag


def found(path, mapping=None):
    line = fit_lines.line(fit_lines.fittings(Fmu(path).archive, mapping))
    return str(line.mark), line.evidence


def test_a_plant_fits_the_socket_of_the_plant(built_fmus):
    assert found(built_fmus / "fmi2" / "bicycle.fmu") == ("passes", "plant: fits as it is")
    assert found(built_fmus / "fmi3" / "mpc.fmu") == ("passes", "controller: fits as it is")
    assert found(built_fmus / "fmi3" / "ramp_traffic.fmu") == ("passes", "traffic: fits as it is")


def test_an_fmu_for_no_socket_need_not_fit(tmp_path):
    mark, evidence = found(lag(tmp_path))
    assert mark == "does not apply"
    assert evidence.startswith("plant: does not fit, 0 of 8 signals found; ")


def test_a_mapping_is_for_one_socket(tmp_path):
    mapping = read_mapping(foreign.right_handed_mapping(tmp_path), "plant")
    assert found(mapping.fmu, mapping) == ("passes", "plant: fits, with the conversions that check lists")
