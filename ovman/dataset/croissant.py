"""croissant.json: the data set in Croissant 1.1 with the vocabulary for responsible AI, which the NeurIPS track asks for.

Names of files are relative to croissant.json, so that a copy of the folder is read where it lies. With a page they are below that
page, as Hugging Face has them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ovman.dataset.about import LICENCE, About
from ovman.dataset.columns import Column, Kind, Table
from ovman.dataset.files import DataFile

PARQUET = "application/x-parquet"
REPOSITORY = "repository"
CONFORMS_TO = ("http://mlcommons.org/croissant/1.1", "http://mlcommons.org/croissant/RAI/1.0")
CONTEXT: Mapping[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "containedIn": "cr:containedIn",
    "cr": "http://mlcommons.org/croissant/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "fileProperty": "cr:fileProperty",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "prov": "http://www.w3.org/ns/prov#",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}


def croissant(about: About, tables: Sequence[Table], files: Sequence[DataFile], said: Mapping[str, Any]) -> dict[str, Any]:
    """The metadata of the data set. tables: those of which there are files; said: as `ovman.dataset.about.responsible`."""
    return {
        "@context": dict(CONTEXT),
        "@type": "sc:Dataset",
        "conformsTo": list(CONFORMS_TO),
        "name": about.name,
        "alternateName": about.title,
        "description": about.description,
        "version": about.version,
        "license": LICENCE,
        "creator": [{"@type": "sc:Organization", "name": author} for author in about.authors],
        "keywords": list(about.keywords),
        "inLanguage": "en",
        "citeAs": about.bibtex,
        **({} if about.url is None else {"url": about.url}),
        **({} if about.day is None else {"datePublished": about.day}),
        "isLiveDataset": False,
        **{f"rai:{name}": _one_line(text) for name, text in said["rai"].items()},
        "prov:wasDerivedFrom": [
            {"@id": one["url"], "@type": "prov:Entity", "prov:label": one["name"]} for one in said["derived_from"]
        ],
        "prov:wasGeneratedBy": [
            {"@type": "prov:Activity", "prov:label": one["name"], "sc:description": one["about"]} for one in said["generated_by"]
        ],
        "distribution": [
            *([] if about.url is None else [_repository(about.url)]),
            *(_file_object(file, about.url) for file in files),
            *(_file_set(table, about.url) for table in tables),
        ],
        "recordSet": [_record_set(table) for table in tables],
    }


def _repository(url: str) -> dict[str, Any]:
    """The page's Git repository, in which the sets of files lie."""
    return {
        "@type": "cr:FileObject",
        "@id": REPOSITORY,
        "name": REPOSITORY,
        "description": "the data set's repository",
        "contentUrl": url,
        "encodingFormat": "git+https",
        # No digest of a repository is defined; this is what the format asks for in its place.
        "sha256": "https://github.com/mlcommons/croissant/issues/80",
    }


def _file_object(file: DataFile, url: str | None) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": file.name,
        "name": file.name,
        "description": f"{file.table} of the split {file.split}",
        "contentUrl": file.name if url is None else f"{url}/resolve/main/{file.name}",
        "contentSize": f"{file.size} B",
        "encodingFormat": PARQUET,
        "sha256": file.sha256,
    }


def _file_set(table: Table, url: str | None) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": f"{table.name}-files",
        "name": f"{table.name}-files",
        "description": f"all files of the table {table.name}",
        **({} if url is None else {"containedIn": {"@id": REPOSITORY}}),
        "encodingFormat": PARQUET,
        "includes": table.file("*", "*"),
    }


def _record_set(table: Table) -> dict[str, Any]:
    return {
        "@type": "cr:RecordSet",
        "@id": table.name,
        "name": table.name,
        "description": table.about,
        "field": [_field(table, column) for column in table.columns],
    }


def _field(table: Table, column: Column) -> dict[str, Any]:
    # A picture is a struct of its bytes and a path that is not used.
    transform = {"transform": {"jsonPath": "bytes"}} if column.kind is Kind.IMAGE else {}
    whose = "truth, for the evaluator alone: " if column.truth else ""
    return {
        "@type": "cr:Field",
        "@id": f"{table.name}/{column.name}",
        "name": column.name,
        "description": f"{whose}{column.about}",
        "dataType": column.kind.value.croissant,
        "source": {"fileSet": {"@id": f"{table.name}-files"}, "extract": {"column": column.name}, **transform},
    }


def _one_line(text: Any) -> Any:
    if isinstance(text, list):
        return [_one_line(one) for one in text]
    return " ".join(text.split()) if isinstance(text, str) else text
