"""The bench `iftomm`: the problems A01 to A05 of the IFToMM multibody benchmark."""
