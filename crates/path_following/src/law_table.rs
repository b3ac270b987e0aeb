//! The form of a table of laws: one row for each, and everything that lists them is made of the rows.

/// An enum of laws by name: a row is the variant, the word for it in a mission, one sentence, and what makes the law.
macro_rules! law_table {
    (
        $(#[$doc:meta])*
        pub enum $name:ident: $maker:ty {
            $( $(#[$mark:meta])* $variant:ident = $key:literal, $about:literal, $make:expr; )+
        }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub enum $name {
            $( #[doc = $about] $(#[$mark])* $variant, )+
        }

        impl $name {
            /// Every law there is, the usual one first.
            pub const ALL: &'static [Self] = &[$( Self::$variant, )+];

            /// The word for it in a mission.
            pub const fn key(self) -> &'static str {
                match self { $( Self::$variant => $key, )+ }
            }

            /// One sentence on what it does, without a full stop.
            pub const fn about(self) -> &'static str {
                match self { $( Self::$variant => $about, )+ }
            }

            /// The law with this word in a mission.
            pub fn by_key(key: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|law| law.key() == key)
            }

            fn maker(self) -> $maker {
                match self { $( Self::$variant => $make, )+ }
            }
        }

        impl settings::Choice for $name {
            const ALL: &'static [Self] = Self::ALL;

            fn key(self) -> &'static str {
                self.key()
            }

            fn about(self) -> &'static str {
                self.about()
            }
        }
    };
}

pub(crate) use law_table;
