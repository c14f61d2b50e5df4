"""The bill of materials in CycloneDX's format."""

from __future__ import annotations

import json
from collections.abc import Iterable
from datetime import datetime, timezone
from pathlib import Path
from uuid import NAMESPACE_URL, uuid5

from cyclonedx.contrib.license.factories import LicenseFactory
from cyclonedx.model import ExternalReference, ExternalReferenceType, HashAlgorithm, HashType, XsUri
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component as Item
from cyclonedx.model.component import ComponentType
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL

from tools.supply_chain.component import Component

NAME = "rover"
LICENCES = LicenseFactory()


def bill(components: Iterable[Component], models: Iterable[Path], version: str, commit: str, at: int) -> str:
    """A JSON document; the same input gives the same bytes.

    models: ONNX files, each with a file `.sha256` beside it; at: when `commit` was made, seconds since 1970.
    """
    rover = Item(name=NAME, version=version, type=ComponentType.APPLICATION, bom_ref=NAME)
    rover.licenses.add(LICENCES.make_from_string("Apache-2.0"))
    bom = Bom(serial_number=uuid5(NAMESPACE_URL, f"{NAME}@{commit}"))
    bom.metadata.component = rover
    bom.metadata.timestamp = datetime.fromtimestamp(at, timezone.utc)
    items = [_library(component) for component in sorted(components)] + [_model(model) for model in sorted(models)]
    for item in items:
        bom.components.add(item)
    bom.register_dependency(rover, items)
    return json.dumps(json.loads(JsonV1Dot6(bom).output_as_string()), indent=2, sort_keys=True) + "\n"


def _library(component: Component) -> Item:
    url = component.package_url
    item = Item(
        name=component.name,
        version=component.version,
        type=ComponentType.LIBRARY,
        purl=PackageURL.from_string(url),
        bom_ref=url,
    )
    if component.licence:
        item.licenses.add(LICENCES.make_from_string(component.licence))
    # A package has a file for each system: they are alternatives, so none is the package's own hash.
    if component.sha256:
        hashes = [_sha256(each) for each in component.sha256]
        item.external_references.add(
            ExternalReference(type=ExternalReferenceType.DISTRIBUTION, url=XsUri(url), hashes=hashes)
        )
    return item


def _model(file: Path) -> Item:
    item = Item(name=file.name, type=ComponentType.MACHINE_LEARNING_MODEL, bom_ref=f"model:{file.name}")
    item.hashes.add(_sha256(file.with_suffix(".sha256").read_text().split()[0]))
    return item


def _sha256(content: str) -> HashType:
    return HashType(alg=HashAlgorithm.SHA_256, content=content)
