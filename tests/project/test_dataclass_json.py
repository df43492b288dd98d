"""Documents as JSON."""

from __future__ import annotations

import json

from retime.project.dataclass_json import from_value, to_value
from retime.project.document import (
    Document,
)
from tests.project.documents import document_of


def test_a_document_is_json_and_back(tmp_path) -> None:
    document = document_of(tmp_path)
    assert from_value(Document, json.loads(json.dumps(to_value(document))), "document") == document
