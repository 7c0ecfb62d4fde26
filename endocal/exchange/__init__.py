"""Lens models as other tools write them: text and arrays out, text in. No file is touched here."""
