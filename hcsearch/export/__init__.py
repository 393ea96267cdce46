"""Export to file formats of other programs: crease patterns, sheets, pictures, tables, solids, simulation models.

`formats.EXPORT_FORMATS` lists the formats.
"""
