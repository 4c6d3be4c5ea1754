"""The figures of the paper, one module each: PNG for pages, PDF for print, at the width at which they are printed."""
