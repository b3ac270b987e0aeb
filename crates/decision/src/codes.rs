//! The registry of problems. A code, once released, keeps its meaning for ever.

use std::fmt;

/// Whether a problem stops the program from being built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The program runs, but probably not as meant.
    Warning,
    /// No program comes out.
    Error,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Warning => "warning",
            Self::Error => "error",
        })
    }
}

macro_rules! codes {
    ($($variant:ident $id:ident $severity:ident $title:literal;)*) => {
        /// Every problem the compiler and the machine can report.
        ///
        /// `R1xxx` syntax, `R2xxx` types and values, `R3xxx` flow, `R8xxx` run time, `R9xxx` our
        /// own mistakes. Each has a page in `docs/problems/`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum Code {
            $(#[doc = $title] $variant,)*
        }

        impl Code {
            /// Every code, by number.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// The stable name, also the name of its page.
            pub fn id(self) -> &'static str {
                match self { $(Self::$variant => stringify!($id),)* }
            }

            /// One line on what it means.
            pub fn title(self) -> &'static str {
                match self { $(Self::$variant => $title,)* }
            }

            /// Whether it stops the program from being built.
            pub fn severity(self) -> Severity {
                match self { $(Self::$variant => Severity::$severity,)* }
            }

            /// Its page: what it means, a failing program, the corrected one. Markdown.
            pub fn page(self) -> &'static str {
                match self {
                    $(Self::$variant =>
                        include_str!(concat!("../../../docs/problems/", stringify!($id), ".md")),)*
                }
            }
        }
    };
}

codes! {
    UnknownMnemonic R1001 Error "The line begins with no known function.";
    LoneLabel R1002 Error "A label stands before nothing.";
    IncompleteEqu R1003 Error "An EQU lacks its name or its value.";
    TooFewOperands R1004 Error "A function has fewer operands than it needs.";
    TooManyOperands R1005 Error "A function or an EQU has more operands than it takes.";
    UnclosedQuote R1006 Error "A quoted text does not end on its line.";
    UnexpectedCharacter R1007 Error "A character that no field may contain.";
    MalformedNumber R1008 Error "A number with digits that its notation lacks.";
    MalformedName R1009 Error "A label or an EQU name that is not a name.";
    OperandBeyondLast R1010 Warning "Text after the last operand looks like one more operand.";
    SecondFunction R1011 Warning "A second function stands on the line, and is left out.";
    SourceTooLarge R1012 Error "The text is larger than any program can be.";
    OtherEncoding R1013 Warning "The text is not UTF-8; it was read as something else.";
    TextAfterEnd R1014 Warning "Text stands after the end-of-file character, and is left out.";
    TooManyProblems R1999 Warning "More problems than are worth listing.";
    UnknownName R2001 Error "A name that nothing carries.";
    NumberTooLarge R2002 Error "The family of resources exists, but not that member.";
    ReadOnlyDestination R2003 Error "A function writes to a resource that programs cannot write.";
    ConstantForResource R2004 Error "A constant stands where a resource is needed.";
    ResourceForConstant R2005 Error "A resource stands where a constant is needed.";
    ValueOutOfRange R2006 Error "A constant is outside the range of its operand.";
    OscillatorOnEdge R2007 Error "An oscillator is told to run on an edge.";
    NameTaken R2008 Error "A label or an EQU name is used twice.";
    NameReserved R2009 Error "A label or an EQU takes a name of the language.";
    NumberAsBoolean R2010 Warning "A number is used where one bit is looked at.";
    BooleanAsNumber R2011 Warning "A history of one bit is used as a number.";
    WordOutOfPlace R2012 Warning "A word such as RISE stands where another kind of constant belongs.";
    LostWrite R3001 Warning "A resource is written again later in the same scan.";
    TimerReused R3002 Warning "Two functions use the same timer.";
    TriggerNeverWritten R3003 Warning "The trigger of a MOVE never changes.";
    NeverWritten R3004 Warning "A resource is read, but nothing writes it.";
    TimerNeverStarted R3005 Warning "The output of a timer is read, but no TIMER drives it.";
    ConditionNeverTrue R3006 Warning "A condition that cannot come true.";
    ActsEveryScan R3007 Warning "A MOVE or EVENT on a level acts in every scan.";
    ScanTooLong R3008 Warning "So many functions that a scan takes more than 200 ms.";
    ImageTooLarge R3009 Warning "An image larger than the 4096 bytes of the target.";
    NoFunctions R3010 Warning "A program without a single function.";
    UnknownOpcode R8001 Error "The machine met an opcode that no function has.";
    TruncatedImage R8002 Error "The image ends inside an instruction or without an end.";
    UnknownAddress R8003 Error "An instruction names an address that no resource has.";
    WatchdogReset R8004 Error "The machine was restarted, because its loop stood still.";
    ImageValueOutOfRange R8005 Error "An instruction carries a constant outside its range.";
    ScanOverrun R8006 Error "A scan took longer than the 200 ms it may take.";
    ImageMismatch R9001 Error "The encoder and the decoder of images disagree; our mistake.";
}

impl Code {
    /// The code of that name, such as `R2001`, in either case.
    pub fn by_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|code| code.id().eq_ignore_ascii_case(id))
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}
