"""Results as KML, for Google Earth and handheld receivers: WGS 84, so only for a mission that has an origin."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree as Xml

from rover.report.geojson import results_geojson
from rover.report.result import RunResult

NAMESPACE = "http://www.opengis.net/kml/2.2"
WORLD_FILE = "detections.kml"

# Style by kind of feature: colours are aabbggrr.
STYLES = {
    "indication": ("ff2020e0", "00000000"),
    "keep-out zone": ("ff2020e0", "402020e0"),
    "goal": ("ffe0a020", "00000000"),
    "path": ("ffffffff", "00000000"),
    "area": ("ff808080", "10808080"),
}


def results_kml(result: RunResult) -> bytes:
    """The features of `results_geojson` as placemarks. Raises ValueError without an origin on the earth."""
    if result.site.origin is None:
        raise ValueError("a mission without an origin has no place on the earth")
    root = Xml.Element("kml", xmlns=NAMESPACE)
    document = Xml.SubElement(root, "Document")
    Xml.SubElement(document, "name").text = _legal(f"Survey: {result.mission}")
    simulated = "Simulated field: no real ground was surveyed. " if result.identities.simulated else ""
    Xml.SubElement(document, "description").text = (
        f"{simulated}Indications are places that may hold a mine; ground without one is surveyed, no more."
    )
    for kind, (line, fill) in STYLES.items():
        style = Xml.SubElement(document, "Style", id=_style(kind))
        for name, colour in (("IconStyle", line), ("LineStyle", line), ("PolyStyle", fill)):
            Xml.SubElement(Xml.SubElement(style, name), "color").text = colour
    for feature in results_geojson(result)["features"]:
        _placemark(document, feature)
    Xml.indent(root)
    content: bytes = Xml.tostring(root, encoding="utf-8", xml_declaration=True)
    return content + b"\n"


def _placemark(parent: Xml.Element, feature: dict[str, Any]) -> None:
    properties, geometry = feature["properties"], feature["geometry"]
    mark = Xml.SubElement(parent, "Placemark")
    number = properties.get("id", properties.get("detection", ""))
    Xml.SubElement(mark, "name").text = f"{properties['kind']} {number}".strip()
    Xml.SubElement(mark, "styleUrl").text = f"#{_style(properties['kind'])}"
    data = Xml.SubElement(mark, "ExtendedData")
    for key, value in properties.items():
        if isinstance(value, dict):
            continue
        entry = Xml.SubElement(data, "Data", name=key)
        Xml.SubElement(entry, "value").text = _legal("" if value is None else str(value))
    kind, coordinates = geometry["type"], geometry["coordinates"]
    shape = Xml.SubElement(mark, kind)
    if kind == "Polygon":
        ring = Xml.SubElement(Xml.SubElement(shape, "outerBoundaryIs"), "LinearRing")
        Xml.SubElement(ring, "coordinates").text = _tuples(coordinates[0])
    else:
        Xml.SubElement(shape, "coordinates").text = _tuples([coordinates] if kind == "Point" else coordinates)


def _tuples(points: list[list[float]]) -> str:
    return " ".join(f"{longitude:.9f},{latitude:.9f}" for longitude, latitude in points)


def _style(kind: str) -> str:
    return kind.replace(" ", "-")


def _legal(text: str) -> str:
    """Without the control characters that XML cannot hold at all."""
    return "".join(c if _is_legal(c) else "\ufffd" for c in text)


def _is_legal(character: str) -> bool:
    if character < " ":
        return character in "\t\n\r"
    return not ("\ud800" <= character <= "\udfff" or character in "\ufffe\uffff")
