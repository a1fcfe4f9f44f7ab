//! `index.html`: a single self-contained file that opens from disk.

use crate::report::canvas::width_mm;
use crate::report::figure::Figure;
use crate::report::style;

const STYLE: &str = "
body{font:17px/1.5 Georgia,'Times New Roman',serif;color:#222;max-width:52rem;margin:3rem auto;padding:0 1.2rem}
h1{font-size:1.9rem;line-height:1.2;margin:0 0 .3rem}h2{font-size:1.25rem;margin:2.6rem 0 .6rem}
.verdict{border-left:4px solid #0072b2;padding:.2rem 0 .2rem 1rem;font-size:1.1rem}.verdict.refused{border-color:#d55e00}
.lead{color:#555}dt{font-style:italic;color:#555;margin-top:.6rem}dd{margin:0}
figure{margin:2rem 0}figure svg{width:100%;height:auto;display:block}figcaption{font-size:.88rem;color:#444;margin-top:.5rem}
.scroll{overflow-x:auto}.wide{width:min(94vw,78rem);margin-left:50%;transform:translateX(-50%)}.wide table{margin-left:auto;margin-right:auto}.caption{font:italic .9rem Georgia,serif;margin:1.6rem 0 0}
.facts{display:flex;flex-wrap:wrap;gap:.6rem 2.4rem;margin:1.2rem 0;font-size:.85rem;color:#555}.facts b{display:block;font:600 1.25rem 'Liberation Sans',Arial,Helvetica,sans-serif;color:#222}
tr.pick td{font-weight:bold;background:#e6f0f7}summary{cursor:pointer;margin:.6rem 0}
table{border-collapse:collapse;font:13px/1.45 'Liberation Sans',Arial,Helvetica,sans-serif;margin:.6rem 0;border-top:2px solid #222;border-bottom:2px solid #222}
th{font-weight:normal;border-bottom:1px solid #222;text-align:left;vertical-align:bottom}th,td{padding:.22rem .7rem .22rem 0;white-space:nowrap}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}@media print{details:not([open])>*{display:block}}
details pre{font-size:12px;line-height:1.35;overflow-x:auto;background:#f5f5f5;padding:.8rem}code{font-size:.9em}";

/// Returns a whole page with this body.
pub fn document(title: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n<title>{} – Durometer</title>\n<style>{STYLE}</style></head><body>\n{body}</body></html>\n",
        escape(title)
    )
}

/// Returns a numbered figure with its caption.
pub fn drawing(f: &Figure, number: usize) -> String {
    format!(
        "<figure id=\"{0}\">\n{1}<figcaption>Figure {number}. {2} <a href=\"figures/{0}.pdf\">PDF</a></figcaption></figure>\n",
        f.name,
        sized(&f.svg),
        escape(&f.caption)
    )
}

/// Returns a bulleted list of plain texts.
pub fn list(items: impl Iterator<Item = String>) -> String {
    items.fold(String::from("<ul>\n"), |h, item| h + &format!("<li>{}</li>\n", prose(&item))) + "</ul>\n"
}

/// On the page, a figure takes the same fraction of the width as it takes of the width of its style.
fn sized(svg: &str) -> String {
    let mm = width_mm(svg);
    svg.replacen("<svg ", &format!("<svg style=\"width:{:.0}%\" ", 100.0 * mm / style::current().width_mm), 1)
}

/// Sets names between backticks as code; a single backtick is kept.
pub fn prose(s: &str) -> String {
    let mut parts = s.split('`');
    let mut h = escape(parts.next().unwrap_or_default());
    while let Some(code) = parts.next() {
        match parts.next() {
            Some(next) => h += &format!("<code>{}</code>{}", escape(code), escape(next)),
            None => h += &format!("`{}", escape(code)),
        }
    }
    h
}

pub fn escape(s: &str) -> String {
    s.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_between_backticks_are_code() {
        assert_eq!(prose("add `<a>` & `b`, then"), "add <code>&lt;a&gt;</code> &amp; <code>b</code>, then");
        assert_eq!(prose("5` and <b>"), "5` and &lt;b&gt;");
        assert_eq!(prose(""), "");
    }
}
