# SPDX-License-Identifier: MIT
"""What a header says about where it comes from."""

from __future__ import annotations

import re
from dataclasses import dataclass

# Words that no namespace can be called by: of the language, and of the libraries that a program includes.
RESERVED = frozenset(
    """
    alignas alignof and and_eq asm auto basix bitand bitor bool break case catch char char8_t char16_t char32_t class
    compl concept const consteval constexpr constinit const_cast continue co_await co_return co_yield decltype default
    delete do dolfinx dolfinx_impact double dynamic_cast else enum explicit export extern false float for friend goto if
    inline int long main mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public
    register reinterpret_cast requires return short signed sizeof static static_assert static_cast std struct switch
    template this thread_local throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t
    while xor xor_eq
    """.split()
)


@dataclass
class Origin:
    """What a header was made of.

    Attributes:
        file: name of the user's file, without its folder.
        command: command that makes the same kernels.
        versions: versions of the libraries, by name.
    """

    file: str
    command: str
    versions: dict[str, str]

    @property
    def stem(self) -> str:
        """Name of the file without its ending: name of the header and of its namespace."""
        return self.file.rpartition(".")[0]

    def check(self) -> None:
        """Refuse a file whose name is none in C++.

        Raises:
            ValueError: it is not.
        """
        valid = re.fullmatch(r"[A-Za-z]\w*\.\w+", self.file, re.ASCII)
        if not valid or self.stem in RESERVED or "__" in self.stem:
            raise ValueError(
                f"the namespace of the kernels has the name of the file, and {self.file} gives none in C++: rename it, "
                "as my_law.py"
            )
