"""Files that other programs read: crease patterns, sheets, pictures, tables, solids and models of simulators.

`formats.FORMATS` lists the formats, a module each.
"""
